# SPDX-License-Identifier: Apache-2.0
"""32-bit counters that wrap, and the slope over the last samples of a counter."""

from __future__ import annotations

_HALF = 1 << 31
_MASK = (1 << 32) - 1


def counts_between(before: int, now: int) -> int:
    """Counts from one reading to the next, by the shorter way round the 32-bit range."""
    return ((now - before + _HALF) & _MASK) - _HALF


def wrapped(counts: int) -> int:
    """Wrap a count to int32, as on the bus."""
    return ((counts + _HALF) & _MASK) - _HALF


class SlopeCounter:
    """Unwrapped counts and their least-squares slope over the last n samples.

    The sums are integers, so the slope does not drift. The quantization of the counts (variance
    1/12) gives the slope through n samples a variance of 1/(n (n^2 - 1)) counts^2 per sample^2.
    The slope lags by (n - 1)/2 samples when the speed changes. So n trades noise for delay.
    """

    __slots__ = ("_at", "_factor", "_mean", "_n", "_raw", "_ring", "_s0", "_s1", "counts", "slope")

    def __init__(self, samples: int) -> None:
        self._n = max(int(samples), 2)
        self._factor = 12.0 / (self._n * (self._n**2 - 1))
        self._mean = (self._n - 1) / 2.0
        self._raw: int | None = None
        self.counts = 0
        """unwrapped counts"""
        self.slope = 0.0
        """[counts/sample]"""
        self.refill(0)

    def refill(self, counts: int) -> None:
        """Reset the history as if the counter had always stood at `counts`."""
        n = self._n
        self._ring = [counts] * n
        self._at = 0
        self._s0 = n * counts
        self._s1 = n * (n - 1) // 2 * counts
        self.counts, self.slope = counts, 0.0

    def update(self, raw: int) -> int:
        """Add a reading; returns the counts since the previous one."""
        if self._raw is None:
            self._raw = raw
            self.refill(raw)
            return 0
        moved = ((raw - self._raw + _HALF) & _MASK) - _HALF
        self._raw = raw
        counts = self.counts + moved
        at, ring, last = self._at, self._ring, self._n - 1
        oldest = ring[at]
        ring[at] = counts
        self._at = at + 1 if at < last else 0
        rest = self._s0 - oldest
        # every older sample moves down by one index, the new one gets index n - 1
        self._s1 += last * counts - rest
        self._s0 = rest + counts
        self.counts = counts
        self.slope = self._factor * (self._s1 - self._mean * self._s0)
        return moved

    def bridge(self, raw: int, gap: int) -> None:
        """Add readings for the lost samples before `raw`, which comes `gap` samples after the
        last one."""
        before = raw if self._raw is None else self._raw
        moved = counts_between(before, raw)
        for k in range(1, gap):
            self.update(before + moved * k // gap)

    def rezero(self, raw: int) -> None:
        """Continue from `raw` without motion, after the device has reset its counter."""
        self._raw = raw

    def back(self, samples: int) -> int:
        """Counts `samples` samples ago (at most n - 1)."""
        return self._ring[self._at - 1 - samples]
