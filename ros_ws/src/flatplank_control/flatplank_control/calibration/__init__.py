# SPDX-License-Identifier: Apache-2.0
"""Calibration of the instruments, each with date, residual and uncertainty."""

from flatplank_control.calibration.book import Book, Entry
from flatplank_control.calibration.line import Line, fit_line

__all__ = ["Book", "Entry", "Line", "fit_line"]
