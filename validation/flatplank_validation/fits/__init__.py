# SPDX-License-Identifier: Apache-2.0
"""Measured numbers of the analysis; every ratio comes from one run on one machine."""
