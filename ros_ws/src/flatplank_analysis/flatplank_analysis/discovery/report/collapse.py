# SPDX-License-Identifier: Apache-2.0
"""Data of the picture of an effect over its coordinate, on which all runs lie on one curve."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.fit import effect_contribution
from flatplank_analysis.discovery.steps import Search


@dataclass(frozen=True)
class Collapse:
    """Arrays of shape (runs, samples); forces are those of the first channel."""

    effect: str
    coordinate: str
    unit: str
    """of the coordinate"""
    places: np.ndarray
    """coordinate of each sample"""
    left: np.ndarray
    """residual of the model without the effect"""
    part: np.ndarray
    """the effect"""
    groups: Sequence[tuple[int, np.ndarray]]
    """number of each condition in which the effect shows, and its runs"""

    @property
    def off(self) -> float:
        """Root mean square difference of residual and effect, in the runs that are shown."""
        rows = np.concatenate([rows for _, rows in self.groups])
        return float(np.sqrt(np.mean((self.left[rows] - self.part[rows]) ** 2)))

    def every(self, run: int, points: int) -> np.ndarray:
        """Indices of the samples of a run in the order of the coordinate, about `points`."""
        order = np.argsort(self.places[run], kind="stable")
        return order[:: max(1, len(order) // points)]


def collapse_of(search: Search, number: int) -> Collapse:
    """`number`: of the effect among those that the search has found."""
    last, runs = search.last, search.model.runs
    state, effect = last.state, last.found[number].decision.term.effect
    part = effect_contribution(state.fit, len(state.fit.terms) - len(last.found) + number)[0]
    name = effect.coordinate
    if name not in runs.coordinates:
        name = next(iter(runs.coordinates))
    least = 0.02 * np.abs(part).max()  # a condition with less is not shown
    return Collapse(
        effect=effect.identifier,
        coordinate=name,
        unit=runs.coordinates[name].unit,
        places=runs.coordinates[name].values,
        left=state.residual[0] + part,
        part=part,
        groups=[(i, r) for i, r in enumerate(runs.groups) if np.any(np.abs(part[r]) > least)],
    )
