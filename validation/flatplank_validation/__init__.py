# SPDX-License-Identifier: Apache-2.0
"""Test equipment: kits, benchmarks and studies. It is not installed, and no installed package
imports it."""
