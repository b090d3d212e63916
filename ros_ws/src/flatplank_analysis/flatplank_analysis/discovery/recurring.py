# SPDX-License-Identifier: Apache-2.0
"""Pieces of one record in which its inputs recur (laps, levels, up and down), and a model whose
runs are these pieces.

A record is cut by its inputs (`RunSet.inputs`), never by what was measured.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flatplank_analysis.discovery.model import (
    Model,
    ParameterSet,
    form_error_of,
    starts_of,
    usual_scatter,
)
from flatplank_analysis.discovery.runs import RunSet

SAME = 0.02
"""largest difference, as a share of its range, at which two values of an input count as equal"""
SEGMENTS = 6
"""pieces (conditions) per lap or sweep: an effect must have the same size in all of them"""
COVER = 0.5
"""least share of every record that recurs; data that does not recur is not used"""
SHORTEST = 12
"""least number of nodes of a piece"""
HALF = 0.5
"""least share of the range that an upward or downward sweep covers"""
LONG = 0.04
"""least share of a record for which a level is held"""

_Stretch = tuple[int, str, np.ndarray]
"""run, label of what it repeats, nodes"""


@dataclass(frozen=True)
class Pieces:
    """Pieces of the records that repeat each other."""

    rows: np.ndarray
    """(pieces,) index of the run"""
    nodes: np.ndarray
    """(pieces, samples) indices of its nodes"""
    condition: np.ndarray
    """(pieces,) equal numbers are repeats"""
    names: tuple[str, ...]
    """names of the conditions"""


def lap_pieces(runs: RunSet) -> Pieces | None:
    """Laps of a periodic input, cut into segments; a segment is a condition, laps repeat it."""
    found: list[_Stretch] = []
    for r, values in _inputs(runs):
        begin = _begin(values)
        period = _period(values[:, begin:])
        if not period:
            continue
        segments = max(1, min(SEGMENTS, period // SHORTEST))
        for lap in range((values.shape[1] - begin) // period):
            first = begin + lap * period
            for k, nodes in enumerate(np.array_split(np.arange(period), segments)):
                found.append((r, f"{runs.names[r]}, segment {k + 1} of the lap", first + nodes))
    return _pieces(runs, found)


def _begin(values: np.ndarray) -> int:
    """The last node before the inputs move for the first time."""
    moved = np.abs(values - values[:, :1]).max(axis=0) > 0.1 * SAME
    return max(int(np.argmax(moved)) - 1, 0)


def _period(values: np.ndarray) -> int:
    """Shortest period of the inputs (inputs, samples) in nodes, 0 when there is none."""
    samples = values.shape[1]
    for shift in range(SHORTEST, samples // 2 + 1):
        # a slow input equals itself after any short shift: it must have changed in between
        left = np.abs(values[:, : shift + 1] - values[:, :1]).max() > 0.25
        if left and np.abs(values[:, shift:] - values[:, :-shift]).max() < SAME:
            return shift
    return 0


def level_pieces(runs: RunSet) -> Pieces | None:
    """Levels of the input that are held more than once."""
    found: list[_Stretch] = []
    for r, values in _inputs(runs):
        still = np.abs(np.diff(values, axis=1, prepend=values[:, :1])).max(axis=0) < 0.1 * SAME
        for nodes in _runs_of(still):
            if len(nodes) >= max(SHORTEST, LONG * values.shape[1]):
                # the level, in steps of twice the tolerance, is the label
                level = np.round(values[:, nodes].mean(axis=1) / SAME / 2.0).astype(int)
                found.append((r, f"{runs.names[r]}, level {' '.join(map(str, level))}", nodes))
    return _pieces(runs, found)


def up_and_down_pieces(runs: RunSet) -> Pieces | None:
    """Parts of its range that the input passes both upwards and downwards."""
    stretches: list[_Stretch] = []
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
                label = f"{runs.names[r]}, part {k + 1} of the range"
                stretches.append((r, label, rising[at.round().astype(int)]))
    return _pieces(runs, stretches)


def _smooth(values: np.ndarray, width: int = 5) -> np.ndarray:
    padded = np.pad(values, width // 2, mode="edge")
    return np.convolve(padded, np.full(width, 1.0 / width), mode="valid")


def _inputs(runs: RunSet) -> Iterator[tuple[int, np.ndarray]]:
    """Per run the inputs that vary, scaled to 0 .. 1: (inputs, samples)."""
    for r in range(runs.runs):
        moving = [v[r] for v in runs.inputs.values() if np.ptp(v[r]) > 0.0]
        if moving:
            yield r, np.array([(v - v.min()) / np.ptp(v) for v in moving])


def _runs_of(true: np.ndarray) -> list[np.ndarray]:
    """Node indices of every uninterrupted stretch."""
    nodes = np.flatnonzero(true)
    return np.split(nodes, np.flatnonzero(np.diff(nodes) > 1) + 1) if len(nodes) else []


def _pieces(runs: RunSet, found: Sequence[_Stretch]) -> Pieces | None:
    """Pieces that occur at least twice, with equal node counts; None when too few recur.

    None of `found` is shorter than `SHORTEST`.
    """
    labels = [label for _, label, _ in found]
    again = [s for s in found if labels.count(s[1]) > 1]
    used = [len(np.unique(np.concatenate([n for r, _, n in again if r == run] or [[]])))
            for run in range(runs.runs)]  # fmt: skip
    if not again or min(used) < COVER * runs.samples:
        return None
    count = min(len(nodes) for _, _, nodes in again)
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


class PieceModel:
    """A model whose runs are pieces of its records; the inner model predicts whole records."""

    def __init__(self, model: Model, pieces: Pieces, source: str) -> None:
        """source: identifier of the floor source that needs the pieces."""
        self.model, self.pieces = model, pieces
        self.parameters = model.parameters
        self.form, self.starts = form_error_of(model), starts_of(model)
        self.usual_scatter = usual_scatter(model)
        self.runs = replace(cut_into_pieces(model.runs, pieces), floor_from=source)

    def predict(self, sets: Sequence[ParameterSet]) -> np.ndarray:
        """Predicted channels of the pieces, shape (sets, channels, pieces, samples)."""
        whole = self.model.predict(sets)
        return whole[:, :, self.pieces.rows[:, None], self.pieces.nodes]

    def scatter_directions(self, base: np.ndarray) -> tuple[dict[str, float], ...]:
        """Directions that scatter from run to run, as in the inner model."""
        return self.model.scatter_directions(base)


def cut_into_pieces(runs: RunSet, pieces: Pieces) -> RunSet:
    """The runs as pieces of their records."""
    rows, at = pieces.rows[:, None], pieces.nodes
    time = runs.time[rows, at]
    return replace(
        runs,
        names=tuple(f"{runs.names[r]}, part {i + 1}" for i, r in enumerate(pieces.rows)),
        condition=pieces.condition,
        condition_names=pieces.names,
        measured=runs.measured[:, rows, at],
        time=np.abs(time - time[:, :1]),
        order=np.arange(len(at), dtype=float),
        coordinates={
            k: replace(c, values=c.values[rows, at]) for k, c in runs.coordinates.items()
        },
        inputs={k: v[rows, at] for k, v in runs.inputs.items()},
        roughness=None if runs.roughness is None else runs.roughness[rows, at],
        facts={k: v[pieces.rows] for k, v in runs.facts.items()},
    )
