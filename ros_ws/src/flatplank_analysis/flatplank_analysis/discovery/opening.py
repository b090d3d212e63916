# SPDX-License-Identifier: Apache-2.0
"""How a search begins: its settings, the runs as it takes them, the base from several starts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.fit import Fitter, Term
from flatplank_analysis.discovery.model import Model, starts_of
from flatplank_analysis.discovery.sources import UNDECIDED, cut_where_needed, source_of
from flatplank_analysis.discovery.state import (
    State,
    channel_weights,
    make_state,
    rough_levels,
    start_base,
)
from flatplank_data.errors import FlatplankError
from flatplank_data.progress import Progress

FIRST_STEPS = 6
"""iterations from each further set of start values, before the best one is fitted to the end"""
WORTH_A_FIT = 0.9
"""largest ratio of the errors at which a base that was fitted with the weights of the floors, or
from other starts, replaces the first one; otherwise that is at their optimum already"""


@dataclass
class Options:
    """Settings of the search."""

    progress: Progress | None = None
    start: dict[str, float] = field(default_factory=dict)
    """start values of base parameters"""
    terms: tuple[Term, ...] = ()
    """effects that are in the model already"""
    measured: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    """effect -> parameter -> value [SI] measured on the machine, used as start value"""


def opened(model: Model) -> Model:
    """The model with its runs as a search takes them; FlatplankError without a floor."""
    model = cut_where_needed(model)
    if source_of(model.runs).at_most == UNDECIDED:
        raise FlatplankError("no repeats", "campaign", "repeat at least one condition")
    return model


def fitted_base(model: Model, effects: Sequence[type[Effect]], options: Options) -> State:
    """The base with the channel weights of its floors.

    The first weights come from the scatter alone. A base that is not at the optimum of the weights
    that all later fits use would itself change when an effect is added.
    """
    fitter = Fitter(model, channel_weights(model, rough_levels(model)))
    fit = fitter.fit(start_base(model, options.start), options.terms)
    state = make_state(model, fitter, fit, effects)
    fitter = Fitter(model, channel_weights(model, [f.floor for f in state.floors]))
    fits = [fitter.fit(f.base, f.terms, known=f) for f in (fit, state.whitened.fit)]
    best = min(fits, key=lambda f: f.chi2)
    if fitter.error(best) > WORTH_A_FIT * fitter.error(fit):
        return replace(state, fitter=fitter)
    return make_state(model, fitter, best, effects)


def from_other_starts(
    known: State, effects: Sequence[type[Effect]], options: Options
) -> State | None:
    """The base from the best of its further start values; None when that is no better.

    A few iterations from each set of start values select the one that is fitted to the end.
    """
    fitter = known.fitter
    starts = [{**options.start, **other} for other in starts_of(fitter.model)]
    bases = [start_base(fitter.model, start) for start in starts]
    tries = [fitter.fit(b, options.terms, iterations=FIRST_STEPS) for b in bases]
    begun = min(tries, key=lambda f: f.chi2)
    fit = fitter.fit(begun.base, begun.terms, known=begun)
    if fitter.error(fit) > WORTH_A_FIT * fitter.error(known.fit):
        return None
    return make_state(fitter.model, fitter, fit, effects)
