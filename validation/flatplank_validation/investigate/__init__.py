# SPDX-License-Identifier: Apache-2.0
"""Benchmark of the loop that chooses its own runs."""
