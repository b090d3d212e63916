# SPDX-License-Identifier: Apache-2.0
"""The size from which the fit of an effect starts."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from flatplank_analysis.discovery.fit import Term
from flatplank_analysis.discovery.gram import solve
from flatplank_analysis.discovery.model import ParameterSet
from flatplank_analysis.discovery.screen import ScreenResult
from flatplank_analysis.discovery.state import State, term_of, term_with


def start_of(
    state: State, item: ScreenResult, measured: Mapping[str, float] | None = None
) -> tuple[Term, float]:
    """The term from which the fit of a screened effect starts, and its drop of chi2 by the linear
    sums: at the screened size, or, where the size acts in another way when it is large (a gap) or
    something of it was measured, at the best of several sizes. measured: its parameters [SI]."""
    effect = item.candidate.effect
    if measured or len(effect.starts()) > 1:
        return line_search(state, item, measured or {})
    return term_of(item.candidate, item.sizes), item.gain


def line_search(
    state: State, item: ScreenResult, measured: Mapping[str, float]
) -> tuple[Term, float]:
    """The term at the best of several sizes, and its drop of chi2.

    The best size has the smallest whitened chi2 after one linear step of the base; what this step
    gains without the term is no drop of the term.
    """
    effect, fit = item.candidate.effect, state.whitened.fit
    width = item.sizes if np.any(item.sizes) else np.ones_like(item.sizes)
    terms = [term_of(item.candidate, width * s) for s in (0.5, 1.0, 1.5, 2.2, 3.3, 5.0)]
    terms += [term_of(item.candidate, np.ones_like(width) * s) for s in (1.0, 3.0)]
    terms = [term_with(term, measured) for term in terms]
    own = fit.parameter_set()
    sets = [ParameterSet(own.base, (*own.effects, (effect, t.values))) for t in terms]
    change = state.model.predict(sets) - fit.predicted
    products, scores, _ = state.sums(fit, fit.loose(), change).total()
    n = len(fit.loose())
    inverse = solve(products[:n, :n], scores[:n])[1]
    errors = []
    for i in range(n, n + len(terms)):
        left = scores[:n] - products[:n, i]
        errors.append(products[i, i] - 2.0 * scores[i] - float(left @ inverse @ left))
    best = int(np.argmin(errors))
    alone = float(scores[:n] @ inverse @ scores[:n])
    return terms[best], -errors[best] - alone
