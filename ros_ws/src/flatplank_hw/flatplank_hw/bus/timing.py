# SPDX-License-Identifier: Apache-2.0
"""Durations of a bus in real time: how late it wakes up, and how old its commands are."""

from __future__ import annotations

import time

from flatplank_hw.bus.histogram import Histogram

SHARES = {"p50": 0.5, "p99": 0.99, "p99.9": 0.999, "p99.99": 0.9999, "worst": 1.0}
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
            f"{name} {label} [us]": round(histogram.percentile_us(share), 1)
            for name, histogram in self.durations.items()
            for label, share in SHARES.items()
            if histogram.total
        }
