# SPDX-License-Identifier: Apache-2.0
# setup.cfg describes the package.
from setuptools import setup

setup()
