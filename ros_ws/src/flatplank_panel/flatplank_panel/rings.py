# SPDX-License-Identifier: Apache-2.0
"""A table of fixed size that forgets its oldest rows: memory stays flat."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


class Ring:
    """The latest `length` rows of `width` numbers; the serial number of rows only grows."""

    def __init__(self, length: int, width: int) -> None:
        self._rows = np.full((length, width), np.nan)
        self.serial = 0
        """rows pushed so far; the latest row has this number"""
        self.begun = 0
        """serial number when it was cleared last"""

    def push(self, row: Sequence[float]) -> None:
        self._rows[self.serial % len(self._rows)] = row
        self.serial += 1

    def clear(self) -> None:
        self.begun = self.serial

    def since(self, serial: int) -> np.ndarray:
        """Rows after number `serial` that are still there, oldest first; shape (n, width)."""
        first = max(serial, self.serial - len(self._rows), self.begun)
        places = np.arange(first, self.serial) % len(self._rows)
        return self._rows[places]
