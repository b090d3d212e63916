# SPDX-License-Identifier: Apache-2.0
"""What a force law of another form explains of the end of a search."""

from __future__ import annotations

from flatplank_analysis.discovery.effect import variants_of
from flatplank_analysis.discovery.fit import Fitter, Term
from flatplank_analysis.discovery.state import State, channel_weights, make_state
from flatplank_analysis.discovery.steps import Search


def fit_with_law_effects(search: Search) -> State | None:
    """The last state with all effects of the force law (`Effect.law`) added and fitted; None when
    there are no further ones."""
    last = search.last.state
    present = {t.effect for t in last.fit.terms}
    pieces = [e for e in search.effects if e.law and e not in present]
    if not pieces:
        return None
    settings = [(e, variants_of(e, search.model.runs, last.residual)) for e in pieces]
    terms = [Term(e, e.vector(s[0]), e.held()) for e, s in settings if s]
    weight = channel_weights(search.model, [f.floor for f in last.floors])
    fitter = Fitter(search.model, weight)
    fit = fitter.fit(last.fit.base, [*last.fit.terms, *terms], iterations=10)
    return make_state(search.model, fitter, fit, [])
