# SPDX-License-Identifier: Apache-2.0
"""Calibrations of the instruments, each with date, residual and uncertainty."""
