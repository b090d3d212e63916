# SPDX-License-Identifier: Apache-2.0
"""Evidence that may be looked at after every batch: e-values by split data.

Before a batch a bet is fixed: the model with the leading effect, as it was fitted to the runs
until then. The new runs alone tell its likelihood against the model without the effect, both with
what those runs leave uncertain of their numbers. Where nothing is missing the ratio is at least
1/alpha in at most a share alpha of all loops, however often the product over the batches is
looked at (Ville's inequality).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from flatplank_analysis.contact_patch.model import TireModel
from flatplank_analysis.contact_patch.tire_runs import TireRuns
from flatplank_analysis.discovery.decide import LAW, Decision
from flatplank_analysis.discovery.fit import Fit, Fitter, priors
from flatplank_analysis.discovery.gram import Metric
from flatplank_analysis.discovery.noise import ChannelNoise, make_whitener
from flatplank_analysis.discovery.shortlist import EVIDENCE
from flatplank_analysis.discovery.state import State, stiff_columns
from flatplank_analysis.discovery.steps import Search
from flatplank_analysis.investigation.settings import Setting, settings_of

ALPHA = 0.05
LIKELY = 0.05
"""p-value among repeats below which an effect that was not accepted is worth a bet"""
LEAST = 1e-12
"""of a variance"""
MOST = 99
"""decimal logarithm beyond which an e-value is no number for people"""


@dataclass(frozen=True)
class Bet:
    """What is claimed before the next runs are seen."""

    names: tuple[str, ...]
    """effects that the tire alone lacks"""
    state: State
    """of the claim, with noise and metric of the runs until then"""
    claim: Fit
    null: Fit
    """the tire alone"""
    dispersion: float
    """of the scores; the likelihood is taken to the power of one over it"""

    @classmethod
    def of(cls, decisions: Sequence[Decision], state: State, claim: Fit, null: Fit) -> Bet:
        """On effects that were judged, against the tire without them."""
        names = tuple(d.term.effect.identifier for d in decisions)
        spread = max(max(d.dispersion, d.dispersion_conditions) for d in decisions)
        return cls(names, state, claim, null, max(spread, 1.0))


def suspect(search: Search) -> Decision | None:
    """The likeliest effect that was refitted and not accepted; None when none is likely."""
    for d in search.last.refits:
        likely = d.p_repeats < LIKELY and d.drop > EVIDENCE
        if likely and not d.term.effect.generic and abs(d.term.size) >= d.matters:
            return d
    return None


def bet_on(search: Search) -> Bet | None:
    """On what was found, else on what is likeliest; None where nothing is."""
    first, last = search.steps[0].state, search.last
    if last.found:
        decisions = [f.decision for f in last.found]
        claim, null = last.state.whitened.fit, first.whitened.fit
    else:
        d = suspect(search)
        if d is None:
            return None
        decisions, null = [d], last.state.whitened.fit
        claim = last.state.with_term(d.term, most=4).fit
    return Bet.of(decisions, last.state, claim, null)


def log_e(bet: Bet, data: TireRuns, rows: np.ndarray) -> float:
    """Logarithm of the e-value of new runs, `rows` of the data of all runs.

    Zero where the bet says nothing of them; see `told_of`.
    """
    known = settings_of(bet.state.runs)
    every = settings_of(data.runs)
    rows = np.array([r for r in rows if told_of(known, every[r])], dtype=int)
    if not len(rows):
        return 0.0
    claim, null = (_surprise(bet.state, fit, data, rows) for fit in (bet.claim, bet.null))
    return (null - claim) / bet.dispersion


def told_of(known: Sequence[Setting], other: Setting) -> bool:
    """Whether runs tell what the tire does in another one: of its load, pressure and side slip,
    and with slips on both sides of its own. Beyond them the law of the tire is a guess, and a
    wrong guess would count as evidence."""
    slips = [s.kappa for s in known if s.condition == other.condition]
    return bool(slips) and min(slips) <= other.kappa <= max(slips)


def _surprise(state: State, fit: Fit, data: TireRuns, rows: np.ndarray) -> float:
    """Negative log predictive density of the new runs by a fit of the old ones, up to what all
    fits have in common."""
    model = TireModel(data)
    model.take_references(state.model)
    model.parameters = state.model.parameters
    fitter = Fitter(model, state.fitter.weight)
    predicted = model.predict([fit.lane()])[0]
    there = fitter.derivative(replace(fit, predicted=predicted))
    runs = data.runs.subset(rows)
    here = replace(there, predicted=predicted[:, rows], jacobian=there.jacobian[:, :, rows])
    metric = _metric(state, model, here, rows)
    loose = fit.loose()
    law = _law(runs.condition, here.predicted)
    columns = np.concatenate([here.jacobian[loose], law])
    gram = metric.gram(runs.measured - here.predicted, columns)
    products, scores, energy = gram.total()
    known = np.zeros_like(products)
    n = len(loose)
    known[:n, :n] = _information(state, fit, loose)
    known[n:, n:] = np.eye(len(law)) / LAW**2
    both = known + products
    explained = float(scores @ np.linalg.solve(both, scores))
    grown = np.linalg.slogdet(both)[1] - np.linalg.slogdet(known)[1]
    return 0.5 * (energy - explained + grown)


def _law(condition: np.ndarray, predicted: np.ndarray) -> np.ndarray:
    """What the law of the tire may be off by: a factor on the first channel in each condition."""
    out = np.zeros((int(condition.max()) + 1, *predicted.shape))
    for c in range(len(out)):
        out[c, 0, condition == c] = predicted[0, condition == c]
    return out


def _metric(state: State, model: TireModel, here: Fit, rows: np.ndarray) -> Metric:
    """Noise and scatter of the old runs, for the new ones."""
    old, runs = state.metric, model.runs.subset(rows)
    noises = [ChannelNoise(n.weights, np.ones(len(rows))) for n in old.whitener.noises]
    return Metric(make_whitener(runs, noises), stiff_columns(model, here), old.scatter)


def _information(state: State, fit: Fit, loose: list[int]) -> np.ndarray:
    """What the old runs, and what was known before, tell of the numbers of a fit."""
    task = state.fitter.task(fit)
    _, width = priors(task.entries)
    residual = fit.residual(state.runs.measured)
    products = state.gram(residual, fit.jacobian[loose]).total()[0]
    own = np.maximum(np.asarray(width, dtype=float)[loose] ** -2.0, LEAST)
    return products + np.diag(own)


@dataclass(frozen=True)
class Evidence:
    """The product over all batches so far."""

    log: float = 0.0
    batches: int = 0
    """of those that had a bet"""

    @classmethod
    def of(cls, answers: Iterable[Mapping[str, Any]]) -> Evidence:
        """Of the answers in a log."""
        found = cls()
        for a in answers:
            found = found.times(a["log_e"], bool(a["bet"]))
        return found

    def times(self, log: float, betted: bool) -> Evidence:
        """With one more batch."""
        return Evidence(self.log + log, self.batches + betted)

    @property
    def e_value(self) -> float:
        """At least 1/alpha: the tire alone is refuted."""
        return math.exp(min(self.log, 700.0))

    @property
    def enough(self) -> bool:
        """Whether it may be said."""
        return self.log >= -math.log(ALPHA)


def times(log: float) -> str:
    """An e-value for people, from its logarithm."""
    if abs(log) < math.log(1e4):
        return f"e = {math.exp(log):.3g}"
    if abs(log) > MOST * math.log(10.0):
        return f"e > 10^{MOST}" if log > 0.0 else f"e < 10^-{MOST}"
    return f"e = 10^{log / math.log(10.0):.0f}"
