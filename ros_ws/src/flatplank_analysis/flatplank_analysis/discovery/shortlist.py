# SPDX-License-Identifier: Apache-2.0
"""Candidates that are worth a refit, and the size from which it starts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.stats import chi2

from flatplank_analysis.discovery.decide import FAMILY, at_edge
from flatplank_analysis.discovery.fit import Term
from flatplank_analysis.discovery.gram import solve
from flatplank_analysis.discovery.model import Model, ParameterSet
from flatplank_analysis.discovery.screen import (
    VISIBLE,
    Screen,
    ScreenResult,
    best_per_effect,
    likeness,
)
from flatplank_analysis.discovery.state import State, term_of

TWINS = 0.995
"""likeness above which the model cannot distinguish two effects; only one of them is refitted"""
HOPE = 0.8
"""least screening gain for a refit, as a share of the test limit: a refit may gain more"""
EVIDENCE = 20.0
"""difference of two chi2 that decides between two models"""

MOSTLY = 0.25
"""visible share of an effect below which its gain is the small difference of large numbers: the
base, which is not linear, may give way further than the screening says"""
MOST_UNSHOWN = 3
"""most effects that are reported although the runs hardly show them"""


def shortlist(ranking: Screen, looked_at: Mapping[str, int], most: int) -> list[ScreenResult]:
    """Candidates with a gain, visible, and of a size that may matter; best first."""
    out: list[ScreenResult] = []
    for item in best_per_effect(ranking):
        effect = item.candidate.effect
        if item.gain < _least_gain(item, looked_at) or item.visible < VISIBLE:
            continue
        if len(effect.starts()) == 1 and negligible(item):
            continue
        # of two effects that the model cannot distinguish one is kept
        alike = [min(likeness(ranking, item, o), likeness(ranking, o, item)) for o in out]
        twin = next((i for i, rho in enumerate(alike) if rho > TWINS), None)
        if twin is not None:
            if _goes_before(item, out[twin]):
                out[twin] = item
            continue
        out.append(item)
        if len(out) == most:
            break
    return out


def mostly_imitated(ranking: Screen, listed: Sequence[ScreenResult]) -> list[ScreenResult]:
    """Candidates beside the listed ones of which the base imitates most (`MOSTLY`), at the size of
    one screening step: only a refit shows what they explain. For gaps see
    `Refits.with_start_sizes`.
    """
    known, out = {item.identifier for item in listed}, []
    for item in best_per_effect(ranking):
        effect = item.candidate.effect
        single = len(effect.linear()) == 1 == len(effect.starts())
        if not single or effect.generic or item.identifier in known:
            continue
        if VISIBLE <= item.visible < MOSTLY:
            out.append(replace(item, sizes=np.ones(1)))
    return out


def unidentifiable(ranking: Screen, looked_at: Mapping[str, int]) -> list[str]:
    """Effects that the residual suggests most, within their range, but of which the tire can
    imitate nearly all, so that these runs cannot name them."""
    level = max(ranking.typical.dispersion, 1.0)
    return [
        item.identifier
        for item in best_per_effect(ranking)
        if item.visible < VISIBLE
        and not item.candidate.effect.generic
        and item.gain > level * _least_gain(item, looked_at)
        and not at_edge(term_of(item.candidate, item.sizes))
    ][:MOST_UNSHOWN]


def _least_gain(item: ScreenResult, looked_at: Mapping[str, int]) -> float:
    """Gain below which no refit is likely to pass the test of the effect."""
    level = FAMILY / looked_at[item.identifier]
    return HOPE * float(chi2.isf(level, len(item.sizes)))


def _goes_before(item: ScreenResult, better: ScreenResult) -> bool:
    """True when the first of two indistinguishable effects is kept: by rarity, then by gain, and
    by name where the data do not decide, so that noise does not choose."""
    one, other = item.candidate.effect.rarity, better.candidate.effect.rarity
    if one != other:
        return one < other
    return better.gain - item.gain < EVIDENCE and item.identifier < better.identifier


def negligible(item: ScreenResult) -> bool:
    """True when the screened size, with what the base may have taken of it, is below half of the
    smallest size of consequence."""
    effect = item.candidate.effect
    values = {p.name: p.null for p in effect.parameters()} | item.candidate.setting
    for p, size in zip(effect.linear(), item.sizes, strict=True):
        values[p.name] = p.null + p.screen * size
    size = abs(effect.size(values)) + effect.in_base
    return size < 0.5 * effect.main_parameter().matters


def line_search(model: Model, state: State, item: ScreenResult) -> Term:
    """The term at the best of several sizes, see `line_search_with_drop`."""
    return line_search_with_drop(model, state, item)[0]


def line_search_with_drop(model: Model, state: State, item: ScreenResult) -> tuple[Term, float]:
    """The term at the best of several sizes, and its drop of chi2.

    The best size has the smallest whitened chi2 after one linear step of the base; what this step
    gains without the term is no drop of the term.
    """
    effect, fit = item.candidate.effect, state.whitened.fit
    width = item.sizes if np.any(item.sizes) else np.ones_like(item.sizes)
    terms = [term_of(item.candidate, width * s) for s in (0.5, 1.0, 1.5, 2.2, 3.3, 5.0)]
    terms += [term_of(item.candidate, np.ones_like(width) * s) for s in (1.0, 3.0)]
    own = fit.parameter_set()
    sets = [ParameterSet(own.base, (*own.effects, (effect, t.values))) for t in terms]
    change = model.predict(sets) - fit.predicted
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
