# SPDX-License-Identifier: Apache-2.0
# What is in the package stands in setup.cfg.
from setuptools import setup

setup()
