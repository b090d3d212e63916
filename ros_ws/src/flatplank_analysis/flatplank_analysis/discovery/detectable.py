# SPDX-License-Identifier: Apache-2.0
"""Smallest size of every effect that a search would name in these runs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.stats import f as f_distribution
from scipy.stats import norm

from flatplank_analysis.discovery.decide import (
    CONDITIONS,
    FAMILY,
    FORM,
    Scatter,
    scatter_among,
)
from flatplank_analysis.discovery.decision import CLEAR
from flatplank_analysis.discovery.dispersion import scores_of
from flatplank_analysis.discovery.gram import Gram
from flatplank_analysis.discovery.screen import VISIBLE, ScreenResult, best_per_effect
from flatplank_analysis.discovery.size_errors import SizeErrors, shifts_of, size_errors
from flatplank_analysis.discovery.state import State
from flatplank_analysis.discovery.steps import Step

POWER = 0.8
"""share of the campaigns in which an effect of this size is named"""


def detectable_sizes(step: Step, looked_at: Mapping[str, int]) -> dict[str, tuple[float, str]]:
    """Smallest size of consequence that is named in most campaigns (`POWER`), with its unit, by
    effect. An effect that these runs cannot show at any size in its range is left out.

    Counted are the scatter among repeats and conditions at the required p-values, and what widens
    the interval, which must be clear of zero: the errors of the force law and of the transients,
    and what the tire can imitate.
    """
    shown = [item for item in best_per_effect(step.screen) if _may_be_named(item)]
    sums = _Sums.of(step.state, shown)
    out: dict[str, tuple[float, str]] = {}
    for place, item in enumerate(shown):
        main = item.candidate.effect.main_parameter()
        level = FAMILY / max(looked_at.get(item.identifier, 1), 1)
        errors, scatter = sums.of_main_parameter(place, step)
        step_size = abs(main.screen)
        least = main.matters / step_size
        size = step_size * smallest_size(errors, scatter, item.visible, level, least)
        if size <= max(main.upper - main.null, main.null - main.lower):
            out[item.identifier] = size, main.unit
    return out


def _may_be_named(item: ScreenResult) -> bool:
    effect = item.candidate.effect
    sized = effect.main_parameter().name in [p.name for p in effect.linear()]
    return sized and not effect.generic and item.visible >= VISIBLE


def smallest_size(
    errors: SizeErrors, scatter: Scatter, visible: float, level: float, least: float
) -> float:
    """Smallest size, in units of that of the direction, which passes all tests with the required
    power; infinite where its interval always covers zero.

    level: p-value required among repeats; least: size that an estimate must reach.
    """
    noise, often = 1.0 / errors.information, float(norm.isf(1.0 - POWER))
    clear = CLEAR * float(norm.isf(0.05))
    repeats = float(f_distribution.isf(level, 1, scatter.freedom))
    conditions = float(f_distribution.isf(CONDITIONS, 1, scatter.freedom_conditions))
    among = scatter.conditions * noise + errors.law
    spread = max(scatter.repeats * noise, among)
    # what the form imitates is a share of the size itself
    left = 1.0 - clear**2 * FORM**2 / visible
    if left <= 0.0:
        return math.inf
    chance = often * math.sqrt(scatter.repeats * noise)
    return max(
        least + chance,
        math.sqrt(repeats * scatter.repeats * noise) + chance,
        math.sqrt(conditions * among) + chance,
        (clear * math.sqrt(spread + errors.late**2) + chance) / math.sqrt(left),
    )


@dataclass(frozen=True)
class _Sums:
    """Sums of the model's own columns, of candidates, and of the errors of the model."""

    state: State
    items: list[ScreenResult]
    gram: Gram

    @classmethod
    def of(cls, state: State, items: list[ScreenResult]) -> _Sums:
        fit = state.whitened.fit
        columns = [item.candidate.columns for item in items]
        gram = state.sums(fit, fit.loose(), *columns, shifts_of(state, fit.predicted))
        return cls(state, items, gram)

    def of_main_parameter(self, place: int, step: Step) -> tuple[SizeErrors, Scatter]:
        """Errors and scatter of the main parameter of one candidate, beside its other ones."""
        fit, item = self.state.whitened.fit, self.items[place]
        effect, columns = item.candidate.effect, item.candidate.columns
        main = [p.name for p in effect.linear()].index(effect.main_parameter().name)
        others = [i for i in range(len(columns)) if i != main]
        own = len(fit.loose())
        first = own + sum(len(i.candidate.columns) for i in self.items[:place])
        base = [*range(own), *(first + i for i in others)]
        last = range(self.gram.scores.shape[1] - 1 - len(fit.predicted), self.gram.scores.shape[1])
        part = self.gram.of_columns([*base, first + main, *last])
        beside = np.concatenate([fit.jacobian[fit.loose()], columns[others]])
        errors = size_errors(self.state, part, len(base), range(len(base)), beside, columns[main])
        scatter = scatter_among(self.state.runs, step.screen.typical, *scores_of(part, len(base)))
        return errors, scatter
