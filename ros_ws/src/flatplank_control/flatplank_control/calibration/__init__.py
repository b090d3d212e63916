# SPDX-License-Identifier: Apache-2.0
"""Calibration of the instruments, each with date, residual and uncertainty."""
