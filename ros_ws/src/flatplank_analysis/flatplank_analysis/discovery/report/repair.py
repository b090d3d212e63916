# SPDX-License-Identifier: Apache-2.0
"""The figure of a repair: the condition that it changed most, before and after."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from flatplank_analysis.discovery.report.figures import (
    AFTER,
    BEFORE,
    legends_beside,
    place_of,
    show_floor,
    with_rest,
)
from flatplank_analysis.discovery.state import State
from flatplank_data.wording import axis_of


def figure_of_repair(before: State, after: State) -> Figure:
    """Mean of the first channel in the common condition whose error fell most, and below what the
    model without effects leaves; before and after. Both states are without effects."""
    condition = _most_changed(before, after)
    runs = after.runs
    name, coordinate = place_of(runs)
    factor, label = axis_of(name, coordinate.unit, coordinate.values[0, [0, -1]])
    figure, curves, rest = with_rest(runs, condition, label)
    number = runs.condition_names.index(condition)
    floor = after.floors[0].by_condition[number]
    show_floor(rest, floor, "floor after")
    for state, style, when in ((before, BEFORE, "before"), (after, AFTER, "after")):
        rows = state.runs.groups[state.runs.condition_names.index(condition)]
        place = factor * place_of(state.runs)[1].values[rows].mean(axis=0)
        error = runs.amount(float(np.sqrt(np.mean(state.residual[0, rows] ** 2))))
        curves.plot(place, state.runs.measured[0, rows].mean(axis=0), **style, label=when)
        left = state.residual[0, rows].mean(axis=0)
        rest.plot(place, left, **style, lw=0.9, label=f"{when}: {error}")
    legends_beside(curves, rest)
    return figure


def _most_changed(before: State, after: State) -> str:
    old, new = (
        dict(zip(s.runs.condition_names, s.floors[0].rmse_condition, strict=True))
        for s in (before, after)
    )
    return max((name for name in old if name in new), key=lambda name: old[name] - new[name])
