# SPDX-License-Identifier: Apache-2.0
"""Zero of the bridges: mean of the corrected volts over a number of samples at rest."""

from __future__ import annotations

from typing import NamedTuple

Channels = tuple[float, float, float, float, float]


class TareStatus(NamedTuple):
    """What became of the last tare."""

    running: bool
    cycle: int
    """cycle from which the present zero is in force; -1: never tared"""
    zero: Channels
    """subtracted from C1, C2, C3, C5, C6 [V]"""
    reason: str
    """why the last tare was given up; empty when it was not"""


class Tare:
    """Sums while it runs; `add` gives the mean with the last sample."""

    __slots__ = ("_left", "_n", "_sums")

    def __init__(self, samples: int) -> None:
        self._n = self._left = samples
        self._sums = [0.0] * 5

    def add(self, volts: Channels) -> Channels | None:
        """One sample; the mean when it was the last one."""
        self._sums = [s + v for s, v in zip(self._sums, volts, strict=True)]
        self._left -= 1
        if self._left:
            return None
        a, b, c, d, e = (s / self._n for s in self._sums)
        return (a, b, c, d, e)
