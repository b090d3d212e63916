# SPDX-License-Identifier: Apache-2.0
"""Durations of a bus in real time: how late it wakes up, and how old its commands are."""

from __future__ import annotations

import re
import time
from collections.abc import Mapping
from typing import Any, NamedTuple

from flatplank_hw.bus.histogram import KEYS, Histogram

REMEMBERED = 64
"""batches whose time is remembered; a command to an older one is not timed"""
MADE, LATE = "cycles made", "cycles late"
"""keys of the counts in /diagnostics"""


class BusTiming:
    """Histograms of a bus since its pace was set; wall times are arguments [ns]."""

    def __init__(self) -> None:
        self.durations = {
            "wake-up": Histogram(), "frame to frame": Histogram(), "stamp to command": Histogram(),
        }  # fmt: skip
        self.made = self.late = 0
        """cycles made, and cycles of a batch that was made later than the next one was due"""
        self._last_ns = 0
        self._sent: dict[int, int] = {}

    def add_wake_up(self, late_ns: int) -> None:
        """Count a wake-up that came `late_ns` after it was due."""
        self.durations["wake-up"].add(late_ns)

    def add_frame(self, cycle: int, cycles: int, now_ns: int) -> None:
        """Count a batch of `cycles` that ends with `cycle` and is sent now."""
        if self._last_ns:
            self.durations["frame to frame"].add(now_ns - self._last_ns)
        self._last_ns = now_ns
        self.made += cycles
        self._sent[cycle] = now_ns
        if len(self._sent) > REMEMBERED:
            del self._sent[next(iter(self._sent))]

    def add_command(self, cycle: int, now_ns: int | None = None) -> None:
        """Count a command that answers `cycle`."""
        sent = self._sent.get(cycle)
        if sent is not None:
            now_ns = time.monotonic_ns() if now_ns is None else now_ns
            self.durations["stamp to command"].add(now_ns - sent)

    def values(self) -> dict[str, float]:
        """Numbers for /diagnostics: counts, and percentiles [us]; none of what never happened."""
        counts: dict[str, float] = {MADE: self.made, LATE: self.late}
        return counts | {
            key: value
            for name, histogram in self.durations.items()
            if histogram.total
            for key, value in labelled(name, histogram.report()).items()
        }


def labelled(name: str, report: Mapping[str, Any]) -> dict[str, float]:
    """Percentiles of a `Histogram.report` [us] with their keys in /diagnostics."""
    return {f"{name} {label} [us]": report[key] for label, key in KEYS.items()}


class ToldTimes(NamedTuple):
    """What a bus tells of its times in /diagnostics."""

    made: int
    """cycles"""
    late: int
    """cycles"""
    durations: dict[str, dict[str, float]]
    """name -> label -> [us]"""

    @property
    def in_words(self) -> str:
        share = self.late / self.made if self.made else 0.0
        return f"{self.late} of {self.made} ({100 * share:.2g} %)"

    @property
    def durations_in_words(self) -> dict[str, str]:
        """Name with underscores -> its percentiles."""
        return {
            re.sub(r"\W", "_", name): ", ".join(f"{label} {us:.0f}" for label, us in found.items())
            + " µs"
            for name, found in self.durations.items()
        }


def told_times(values: Mapping[str, str]) -> ToldTimes | None:
    """The times among the values of a node in /diagnostics; None where it tells none."""
    if MADE not in values or LATE not in values:
        return None
    durations: dict[str, dict[str, float]] = {}
    for label in KEYS:
        for key, value in values.items():
            name, found, _ = key.rpartition(f" {label} [us]")
            if found:
                durations.setdefault(name, {})[label] = float(value)
    return ToldTimes(int(values[MADE]), int(values[LATE]), durations)
