# SPDX-License-Identifier: Apache-2.0
"""Benchmarks of the fits; every ratio comes from one run on one computer."""
