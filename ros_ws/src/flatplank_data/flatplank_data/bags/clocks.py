# SPDX-License-Identifier: Apache-2.0
"""Which time the messages of a bag are joined by: their stamps, or the log time of the recorder.

Stamps are right where they exist: they say when a sample was taken. Stamps that are zero or equal,
a clock that was set during the run, and clocks of two computers are found here, before anything
else is computed; then the log time is used, with a remark. The log time is of one clock: the time
between stamp and log time is a short delay, and the same for all messages but for its spread.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from flatplank_data.errors import FlatplankError

LOG_TIME = "log_time"
ANOTHER = 1.0
"""two topics with a larger difference between stamp and log time have two clocks [s]: no message
of a bench is on its way for so long, other than in a burst, which the spread covers"""
CLEAR = 4.0
"""a shift of a clock is more than this many spreads of the delay"""
_FEW = 3
"""messages before and after a set clock that are needed to see it"""
SYNCHRONISE = f"synchronise the clocks (NTP), or write `time: {LOG_TIME}` in the mapping"


@dataclass(frozen=True)
class Times:
    """Times of the messages of one topic [ns], in the order of the log."""

    topic: str
    log: np.ndarray
    stamp: np.ndarray
    """the log time where a message has no stamp"""
    samples: np.ndarray
    """hash of the samples of each message, shape (messages,)"""

    @property
    def delay(self) -> np.ndarray:
        """Time from stamp to log [s]."""
        return 1e-9 * (self.log - self.stamp)

    @property
    def period(self) -> float:
        """Median distance of the log times [s]."""
        return 1e-9 * float(np.median(np.diff(self.log))) if self.log.size > 1 else 0.0


def times_to_use(
    topics: Mapping[str, Times], base: str, one_clock: bool = False
) -> tuple[dict[str, np.ndarray], list[str]]:
    """Time of each message by topic [ns], and remarks. Raises FlatplankError without a time.

    `one_clock`: all stamps are those of the cycles of one bus, so that any delay is one.
    """
    found = {name: _fault(times) for name, times in topics.items()}
    if not one_clock:
        found = {name: fault or _set_clock(topics[name]) for name, fault in found.items()}
    faults = [fault for fault in found.values() if fault]
    if not (faults or one_clock):
        faults = _two_clocks(topics, base)
    if faults:
        logs = {name: times.log for name, times in topics.items()}
        if not all(_log_tells(times, bool(found[name])) for name, times in topics.items()):
            what = f"{faults[0]}, and the log time tells nothing (written at once?)"
            raise FlatplankError(what, "bag", "record it again with stamps of one clock")
        _check_overlap(logs, base)
        return logs, [f"{fault}: the log time is used; {SYNCHRONISE}" for fault in faults[:1]]
    found = {name: times.stamp for name, times in topics.items()}
    _check_overlap(found, base)
    return found, [] if one_clock else _delays(topics, base)


def _log_tells(times: Times, faulty: bool) -> bool:
    """True unless the log times contradict good stamps, or are all equal."""
    span = 1e-9 * float(np.ptp(times.log))
    return times.log.size < 2 or (span > 0.0 and (faulty or CLEAR * _spread(times.delay) < span))


def _fault(times: Times) -> str:
    """Why the stamps of a topic cannot be used; empty when they can."""
    stamp, name = times.stamp, times.topic
    if stamp.size < 2:
        return ""
    if np.ptp(stamp) == 0:
        return f"the stamps of {name} are all equal ({1e-9 * stamp[0]:.9g} s)"
    zero = int((stamp == 0).sum())
    if zero:
        return f"{zero} of {stamp.size} stamps of {name} are zero"
    order = np.argsort(stamp, kind="stable")
    again = np.diff(stamp[order]) == 0
    other = times.samples[order][1:] != times.samples[order][:-1]
    if (again & other).any():
        count = int((again & other).sum())
        return f"{count} of {stamp.size} stamps of {name} are those of other samples"
    return ""


def _set_clock(times: Times) -> str:
    """The delay from stamp to log time changes for good: the clock was set."""
    if times.stamp.size < 2:
        return ""
    delay = times.delay
    at = int(np.argmax(np.abs(np.diff(delay)))) + 1
    before, after = delay[:at], delay[at:]
    if min(before.size, after.size) < _FEW:
        return ""
    shift = float(np.median(before) - np.median(after))
    if abs(shift) <= max(times.period, CLEAR * max(_spread(before), _spread(after))):
        return ""
    return f"the clock of {times.topic} was set by {shift:+.3f} s at message {at + 1}"


def _spread(values: np.ndarray) -> float:
    low, high = np.percentile(values, (5, 95))
    return float(high - low)


def _shifts(topics: Mapping[str, Times], base: str) -> dict[str, tuple[float, float]]:
    """Topic -> how far its clock is ahead of that of the base, and how far that is seen [s]."""
    ours, out = topics[base], {}
    for name, times in topics.items():
        shift = float(np.median(ours.delay) - np.median(times.delay))
        out[name] = (shift, CLEAR * max(_spread(ours.delay), _spread(times.delay)))
    return out


def _two_clocks(topics: Mapping[str, Times], base: str) -> list[str]:
    return [
        f"{name} and {base} have clocks that differ by {shift:+.3f} s (two computers?)"
        for name, (shift, seen) in _shifts(topics, base).items()
        if abs(shift) > max(ANOTHER, seen) and _log_tells(topics[name], False)
    ]


def _delays(topics: Mapping[str, Times], base: str) -> list[str]:
    """A shift that may be a delay on the way or a difference of clocks."""
    return [
        f"against the log time, stamps of {name} are {1e3 * shift:+.0f} ms off those of {base}; "
        f"if the clocks differ, {SYNCHRONISE}"
        for name, (shift, seen) in _shifts(topics, base).items()
        if abs(shift) > max(topics[base].period, seen)
    ]


def _check_overlap(times: Mapping[str, np.ndarray], base: str) -> None:
    ours = times[base]
    for name, theirs in times.items():
        if theirs.min() > ours.max() or theirs.max() < ours.min():
            a, b = (f"{1e-9 * t.min():.3f} .. {1e-9 * t.max():.3f} s" for t in (theirs, ours))
            what = f"the times of {name} ({a}) and of {base} ({b}) do not overlap"
            raise FlatplankError(what, "bag", SYNCHRONISE)
