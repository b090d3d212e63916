# SPDX-License-Identifier: Apache-2.0
"""Stretches of one record in which its inputs come again: laps, levels, the way back.

A record is cut where its inputs (`RunSet.inputs`) say so, never by what was measured.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.discovery.sources.base import Pieces

SAME = 0.02
"""share of its range within which an input is said to come again"""
SEGMENTS = 6
"""conditions that a lap or a sweep is cut into: an effect must have one size in all of them"""
COVER = 0.5
"""share of every record at least that comes again: what does not is left out of everything"""
SHORTEST = 12
"""nodes of a piece at least"""
HALF = 0.5
"""share of the range that a way up or down covers at least"""
LONG = 0.04
"""share of a record at least for which a level is held"""

_Stretch = tuple[int, str, np.ndarray]
"""run, what it repeats, nodes"""


def laps(runs: RunSet) -> Pieces | None:
    """Laps of a periodic input; each is cut into segments, the conditions."""
    return _pieces(runs, _laps(runs))


def visits(runs: RunSet) -> Pieces | None:
    """Levels of the input that are held, left, and held again."""
    return _pieces(runs, _visits(runs))


def ways(runs: RunSet) -> Pieces | None:
    """The same values of the input upwards and downwards."""
    return _pieces(runs, _ways(runs))


def _laps(runs: RunSet) -> Iterator[_Stretch]:
    for r, values in _inputs(runs):
        begin = _begin(values)
        period = _period(values[:, begin:])
        if not period:
            continue
        segments = max(1, min(SEGMENTS, period // SHORTEST))
        for lap in range((values.shape[1] - begin) // period):
            first = begin + lap * period
            for k, nodes in enumerate(np.array_split(np.arange(period), segments)):
                yield r, f"{runs.names[r]}, segment {k + 1} of the lap", first + nodes


def _begin(values: np.ndarray) -> int:
    """The last node before the inputs move for the first time."""
    moved = np.abs(values - values[:, :1]).max(axis=0) > 0.1 * SAME
    return max(int(np.argmax(moved)) - 1, 0)


def _period(values: np.ndarray) -> int:
    """Shortest shift of the inputs (inputs, samples) after which they come again, 0 without."""
    samples = values.shape[1]
    for shift in range(SHORTEST, samples // 2 + 1):
        # a slow input looks like itself after any short shift: it must have left in between
        left = np.abs(values[:, : shift + 1] - values[:, :1]).max() > 0.25
        if left and np.abs(values[:, shift:] - values[:, :-shift]).max() < SAME:
            return shift
    return 0


def _visits(runs: RunSet) -> Iterator[_Stretch]:
    for r, values in _inputs(runs):
        still = np.abs(np.diff(values, axis=1, prepend=values[:, :1])).max(axis=0) < 0.1 * SAME
        for nodes in _runs_of(still):
            if len(nodes) >= max(SHORTEST, LONG * values.shape[1]):
                # a level is named by the input itself, in whole steps of what counts as the same
                level = np.round(values[:, nodes].mean(axis=1) / SAME / 2.0).astype(int)
                yield r, f"{runs.names[r]}, level {' '.join(map(str, level))}", nodes


def _ways(runs: RunSet) -> Iterator[_Stretch]:
    for r, values in _inputs(runs):
        if len(values) != 1:
            continue
        one = values[0]
        slope = np.sign(np.gradient(_smooth(one)))
        found = [(sign, nodes) for sign in (1.0, -1.0) for nodes in _runs_of(slope == sign)]
        found = [(sign, nodes) for sign, nodes in found if np.ptp(one[nodes]) > HALF]
        if {sign for sign, _ in found} != {1.0, -1.0}:
            continue
        low = max(one[nodes].min() for _, nodes in found)
        edges = np.linspace(low, min(one[nodes].max() for _, nodes in found), SEGMENTS + 1)
        count = max(SHORTEST, min(len(nodes) for _, nodes in found) // SEGMENTS)
        for sign, nodes in found:
            rising = nodes if sign > 0.0 else nodes[::-1]
            for k in range(SEGMENTS):
                places = np.linspace(edges[k], edges[k + 1], count)
                at = np.interp(places, np.maximum.accumulate(one[rising]), np.arange(len(rising)))
                yield (
                    r,
                    f"{runs.names[r]}, part {k + 1} of the range",
                    rising[at.round().astype(int)],
                )


def _smooth(values: np.ndarray, width: int = 5) -> np.ndarray:
    padded = np.pad(values, width // 2, mode="edge")
    return np.convolve(padded, np.full(width, 1.0 / width), mode="valid")


def _inputs(runs: RunSet) -> Iterator[tuple[int, np.ndarray]]:
    """Per run its inputs that move, each over its range: (inputs, samples) within 0 .. 1."""
    for r in range(runs.runs):
        moving = [v[r] for v in runs.inputs.values() if np.ptp(v[r]) > 0.0]
        if moving:
            yield r, np.array([(v - v.min()) / np.ptp(v) for v in moving])


def _runs_of(true: np.ndarray) -> list[np.ndarray]:
    """Nodes of every stretch without a gap."""
    nodes = np.flatnonzero(true)
    return np.split(nodes, np.flatnonzero(np.diff(nodes) > 1) + 1) if len(nodes) else []


def _pieces(runs: RunSet, stretches: Iterable[_Stretch]) -> Pieces | None:
    """What comes at least twice, all cut to as many nodes; None when too little does."""
    found = list(stretches)
    labels = [label for _, label, _ in found]
    again = [s for s in found if labels.count(s[1]) > 1 and len(s[2]) >= 2]
    used = [len(np.unique(np.concatenate([n for r, _, n in again if r == run] or [[]])))
            for run in range(runs.runs)]  # fmt: skip
    if not again or min(used) < COVER * runs.samples:
        return None
    count = max(SHORTEST, min(len(nodes) for _, _, nodes in again))
    names = tuple(dict.fromkeys(label for _, label, _ in again))
    at = [
        nodes[np.round(np.linspace(0, len(nodes) - 1, count)).astype(int)] for *_, nodes in again
    ]
    return Pieces(
        rows=np.array([r for r, _, _ in again]),
        nodes=np.array(at),
        condition=np.array([names.index(label) for _, label, _ in again]),
        names=names,
    )
