# SPDX-License-Identifier: Apache-2.0
"""Samples that are no measurement: spikes of a few samples, and a channel that is stuck.

After Hampel (1974), with scales from the record itself: a spike leaves the line through its
neighbours and comes back to it. Steps, peaks, cleats and stick-slip do not come back at once or
have neighbours that change as much; noise and the steps of a quantised channel are the scale.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from flatplank_data.table import COLUMN_UNITS, MeasurementTable

TESTED = (
    "plank_position", "wheel_angle", "fx", "fy", "fz", "mx", "my", "mz", "loaded_radius",
)  # fmt: skip
"""columns with the inertia or the stiffness of tire and machine behind them"""
LONGEST, ROAD = 5, 0.005
"""longest spike [samples], or [m] of road where that is more: far shorter than a contact patch,
over which a tire averages whatever it feels"""
SIDE = 3
"""neighbours on each side of a spike: a line and its scatter [samples]"""
FAR = 6.0
"""distance from the line of the neighbours, relative to the scale: twelve standard deviations of
white noise. A smaller spike adds less to the error of 150 samples than their noise"""
QUANTILE = 0.9
"""share of the samples that are free of spikes and of their neighbourhood"""
PART = 4096
"""samples at which a spike may begin that are tried at once"""
CHANCE = 1e-6
"""probability that a channel with noise repeats its value for as long as a stuck one by chance"""


@dataclass(frozen=True)
class BadSamples:
    """Bad samples of one column."""

    column: str
    rows: np.ndarray
    """indices of the samples"""
    words: str
    """what is wrong with them"""


def bad_samples(table: MeasurementTable) -> Iterator[BadSamples]:
    """Spikes and stuck stretches of every tested column."""
    if len(table) < 4 * LONGEST:
        return
    longest, moving = _longest(table), _moving(table)
    for name in TESTED:
        if name not in table or not np.isfinite(table[name]).all():
            continue
        values, unit = table[name], COLUMN_UNITS[name]
        rows = np.flatnonzero(spikes(values, longest))
        if rows.size:
            at = ", ".join(f"{values[r]:.4g} {unit} in row {r + 1}" for r in rows[:3])
            more = f" and {rows.size - 3} more" if rows.size > 3 else ""
            yield BadSamples(name, rows, f"spikes: {at}{more}")
        for stretch in stuck(values, moving):
            words = f"stuck at {values[stretch[0]]:.4g} {unit} in rows {stretch[0] + 1}"
            yield BadSamples(name, stretch, f"{words} to {stretch[-1] + 1}")


def _longest(table: MeasurementTable) -> int:
    """Longest spike [samples] at the pace at which the plank moves."""
    if "plank_position" not in table:
        return LONGEST
    pace = np.abs(np.diff(table["plank_position"]))
    pace = pace[pace > 0.0]
    return max(LONGEST, int(ROAD / np.median(pace))) if pace.size else LONGEST


def spikes(values: np.ndarray, longest: int = LONGEST) -> np.ndarray:
    """Mask of the samples (samples,) that belong to a spike of at most `longest` samples."""
    bad = np.zeros(values.size, dtype=bool)
    change = np.abs(np.diff(values))
    quantum = change[change > 0.0].min(initial=np.inf)
    if not np.isfinite(quantum):
        return bad
    bend = np.abs(values[1:-1] - 0.5 * (values[:-2] + values[2:]))
    scale = max(float(np.quantile(bend, QUANTILE)), float(quantum))
    # the samples before and after a spike are off the lines of their neighbours by half as much
    bent = np.flatnonzero(bend > 0.25 * FAR * scale)
    begins = np.concatenate([[0, 1], bent + 2])
    ends = np.concatenate([bent + 1, [values.size - 1, values.size]])
    found = [
        np.stack(stretches)[:, _is_off(values, *stretches, scale)]
        for part in np.array_split(begins, 1 + begins.size // PART)
        if (stretches := _stretches(part, ends, longest, values.size))[0].size
    ]
    first, length, before = np.concatenate([np.zeros((3, 0), dtype=int), *found], axis=1)
    # the shortest first; the ends of the record last, by what is left of it
    for inside in (True, False):
        for size in np.unique(length):
            free = np.flatnonzero((length == size) & ~bad[first] & ((before == SIDE) == inside))
            for k in free[np.argsort(before[free], kind="stable")]:
                rows = np.arange(first[k], first[k] + size)
                bad[rows] = inside or _beyond_all(values, bad, rows)
    return bad


def _stretches(
    begins: np.ndarray, ends: np.ndarray, longest: int, size: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """First samples, lengths and numbers of neighbours before them of the stretches (stretches,)
    from a begin up to an end, in a record of so many samples; each has 2 SIDE neighbours."""
    low, high = np.searchsorted(ends, begins + 1), np.searchsorted(ends, begins + longest, "right")
    count = np.maximum(high - low, 0)
    first = np.repeat(begins, count)
    within = np.arange(first.size) - np.repeat(np.cumsum(count) - count, count)
    length = ends[np.repeat(low, count) + within] - first
    before = np.maximum(np.minimum(first, SIDE), 2 * SIDE + length + first - size)
    fits = before <= first
    return first[fits], length[fits], before[fits]


def _is_off(
    x: np.ndarray, first: np.ndarray, length: np.ndarray, before: np.ndarray, scale: float
) -> np.ndarray:
    """Whether both ends of a stretch are off the straight line that fits its neighbours best
    (stretches,); `before` of the neighbours are before it."""
    at = np.arange(2 * SIDE) - before[:, None]
    at += np.where(at < 0, 0, length[:, None])
    beside, middle = x[first[:, None] + at], at.mean(axis=1, keepdims=True)
    away, level = at - middle, beside.mean(axis=1, keepdims=True)
    slope = (away * beside).sum(axis=1, keepdims=True) / (away**2).sum(axis=1, keepdims=True)
    scatter = np.ptp(beside - level - slope * away, axis=1)
    ends = np.stack([0 * length, length - 1], axis=1)
    off = np.abs(x[first[:, None] + ends] - level - slope * (ends - middle))
    return off.min(axis=1) > FAR * np.maximum(scatter, scale)


def _beyond_all(values: np.ndarray, bad: np.ndarray, rows: np.ndarray) -> bool:
    """Whether samples at an end of the record are farther off than all others, and zero, differ:
    a start from rest looks like a spike, too."""
    good = ~bad
    good[rows] = False
    others = np.append(values[good], 0.0)
    off = np.maximum(values[rows] - others.max(), others.min() - values[rows])
    return bool(off.max() > np.ptp(others))


def _moving(table: MeasurementTable) -> np.ndarray | None:
    """Samples (samples,) at which the plank moves; None where its position is not known."""
    if "plank_position" not in table:
        return None
    position = table["plank_position"]
    pace = np.abs(position[SIDE:] - position[:-SIDE])
    pace = np.pad(pace, (0, position.size - pace.size), mode="edge")
    return pace > 0.5 * np.median(pace[pace > 0.0]) if pace.any() else None


def stuck(values: np.ndarray, moving: np.ndarray | None = None) -> list[np.ndarray]:
    """Stretches (indices) of one value in a channel that has noise before and after them; before
    or after them suffices while the plank moves.

    How often a value repeats elsewhere in the record tells how long it repeats by chance.
    """
    equal = np.diff(values) == 0.0
    edges = np.flatnonzero(np.diff(np.concatenate([[False], equal, [False]]).astype(int)))
    begins, ends = edges[::2], edges[1::2]
    if not begins.size:
        return []
    lengths = ends - begins
    found = []
    for k in np.flatnonzero(lengths > 1):
        elsewhere = (int(equal.sum()) - int(lengths[k]) + 1) / (equal.size - int(lengths[k]) + 1)
        by_chance = values.size * elsewhere ** float(lengths[k])
        sides = (values[: begins[k]], values[ends[k] + 1 :])
        rows = np.arange(begins[k], ends[k] + 1)
        rolls = moving is not None and bool(moving[rows].all())
        if by_chance < CHANCE and (any if rolls else all)(map(_has_noise, sides)):
            found.append(rows)
    return found


def _has_noise(values: np.ndarray) -> bool:
    """Whether a stretch goes up and down from sample to sample."""
    change = np.sign(np.diff(values))
    return bool(np.mean(change[1:] * change[:-1] < 0.0) > 0.25) if change.size > LONGEST else False
