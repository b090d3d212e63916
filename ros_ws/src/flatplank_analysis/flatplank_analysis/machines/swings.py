# SPDX-License-Identifier: Apache-2.0
"""Half swings of something that swings out: from a turn, where the speed is zero, to the next."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.optimize import least_squares

from flatplank_analysis.machines.records import Record, step_of

SMALL = 40.0
"""steps of the record that the amplitude of a half swing has at least"""


def half_swings(record: Record, most: int = 30) -> Iterator[Record]:
    """The record cut at its turns, at most so many pieces, evenly chosen."""
    turns = turning_points(record.time, record.position, step_of(record.position))
    halves = list(zip(turns, turns[1:, 0], strict=False))
    for i, ((begin, top), end) in enumerate(halves[:: max(1, -(-len(halves) // most))]):
        yield Record(
            f"{record.name}, half swing {i + 1}",
            record.time,
            record.position,
            record.inputs,
            record.facts,
            coordinates=record.coordinates,
            span=(begin, end),
            begin=(top, 0.0),
        )


def turning_points(time: np.ndarray, position: np.ndarray, step: float) -> np.ndarray:
    """Time [s] and position of every turn of a swing that the record resolves (turns, 2)."""
    side, turns, last = 0.0, [], 0
    for i, x in enumerate(position):
        if abs(x) > SMALL * step and np.sign(x) != side:
            turns.append((last, i))
            side, last = np.sign(x), i
    spans = [*turns[1:], (last, len(time))]
    peaks = [a + int(np.argmax(np.abs(position[a:b]))) for a, b in spans]
    near = 0.15 * float(np.median(np.diff(time[peaks]))) if len(peaks) > 2 else 0.0
    kept = [p for p in peaks if time[0] + 2.0 * near < time[p] < time[-1] - 2.0 * near]
    return np.array([_vertex(time, position, time[p], near) for p in kept]).reshape(-1, 2)


def _vertex(time: np.ndarray, position: np.ndarray, at: float, near: float) -> tuple[float, float]:
    """Of two half parabolas: with dry friction the curvature is another one after the turn."""
    rows = np.flatnonzero(np.abs(time - at) < near)
    t, x = time[rows] - at, position[rows]

    def off(z):
        u = t - near * z[0]
        return (z[1] + np.where(u < 0.0, z[2], z[3]) * (u / near) ** 2) * scale - x

    scale = float(np.abs(x).max())
    bend = np.polyfit(t / near, x / scale, 2)
    z = least_squares(off, [0.0, bend[2], bend[0], bend[0]]).x
    return at + near * z[0], z[1] * scale
