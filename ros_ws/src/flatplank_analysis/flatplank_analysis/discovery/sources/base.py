# SPDX-License-Identifier: Apache-2.0
"""A source of the floor, and a model seen in pieces that repeat each other."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from flatplank_analysis.discovery.model import Lane, Model, form_of, starts_of, usual_of
from flatplank_analysis.discovery.runs import RunSet

FOUND, PARTLY, UNDECIDED = "found", "partly", "not decidable"


@dataclass(frozen=True)
class Pieces:
    """Stretches of the records that repeat each other."""

    rows: np.ndarray
    """(pieces,) the run that each is of"""
    nodes: np.ndarray
    """(pieces, samples) its nodes"""
    condition: np.ndarray
    """(pieces,) pieces of the same number are repeats"""
    names: tuple[str, ...]
    """of the conditions"""


@dataclass(frozen=True)
class Source:
    """Something that can give a floor."""

    identifier: str
    title: str
    """in words, as it follows 'floor by'"""
    at_most: str
    """the strongest verdict that it allows"""
    offered: Callable[[RunSet], bool | Pieces | None]
    """whether runs have it; pieces, where their records must be cut for it"""
    lower_bound: bool = False
    """the scatter is no smaller, and may be larger"""
    systematic: bool = False
    """what differs between its repeats is ordered: an effect that shows there is the floor"""

    def words(self) -> str:
        """The title, and that it is a lower bound."""
        return self.title + (" (lower bound)" if self.lower_bound else "")

    def to_dict(self) -> dict[str, Any]:
        """For programs: keys of the JSON of `diagnose` and `compare`."""
        return {
            "floor_from": self.words(),
            "floor_is_lower_bound": self.lower_bound,
            "verdict_at_most": self.at_most,
        }


class Seen:
    """A model whose runs are pieces of its records; the model itself predicts whole records."""

    def __init__(self, model: Model, pieces: Pieces, source: str) -> None:
        """source: identifier of the source that wants the pieces."""
        self.model, self.pieces = model, pieces
        self.parameters = model.parameters
        self.form, self.starts = form_of(model), starts_of(model)
        self.usual = usual_of(model)
        self.runs = replace(cut(model.runs, pieces), floor_from=source)

    def predict(self, lanes: Sequence[Lane]) -> np.ndarray:
        """Predicted channels of the pieces, shape (lanes, channels, pieces, samples)."""
        whole = self.model.predict(lanes)
        return whole[:, :, self.pieces.rows[:, None], self.pieces.nodes]

    def stiff(self, base: np.ndarray) -> tuple[dict[str, float], ...]:
        """Directions that scatter, those of the model."""
        return self.model.stiff(base)


def cut(runs: RunSet, pieces: Pieces) -> RunSet:
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
