# SPDX-License-Identifier: Apache-2.0
"""Evidence that may be examined after every batch: e-values by split data.

Before a batch a hypothesis is fixed: the model with the leading effect, as fitted to the runs so
far. The likelihood of the new runs under it is divided by that without the effect, both with the
parameter uncertainty that the old runs leave. Where nothing is missing the product over the
batches reaches 1/alpha in at most a share alpha of all investigations, however often one looks
(Ville's inequality).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from flatplank_analysis.contact_patch.model import TireModel
from flatplank_analysis.contact_patch.tire_runs import TireRuns
from flatplank_analysis.discovery.decision import Decision
from flatplank_analysis.discovery.fit import Fit, Fitter, priors
from flatplank_analysis.discovery.gram import Metric
from flatplank_analysis.discovery.model import form_error_of
from flatplank_analysis.discovery.noise import ChannelNoise, make_whitener
from flatplank_analysis.discovery.state import State, scatter_columns
from flatplank_analysis.discovery.steps import Search
from flatplank_analysis.investigation.settings import Setting, settings_of
from flatplank_data.wording import plain

ALPHA = 0.05
"""largest share of false claims; a claim needs an e-value of its inverse"""
LEAST = 1e-12
"""smallest information of a prior (inverse variance)"""
MOST = 99
"""largest decimal logarithm of an e-value that is printed as a number"""


@dataclass(frozen=True)
class Hypothesis:
    """The claim that is fixed before the next runs are measured."""

    names: tuple[str, ...]
    """effects in the claim and not in the tire alone"""
    state: State
    """state of the claim, with noise and metric of the runs so far"""
    claim: Fit
    null: Fit
    """fit of the tire alone"""
    dispersion: float
    """dispersion of the scores; the likelihood is raised to the power of its inverse"""

    @classmethod
    def of(cls, decisions: Sequence[Decision], state: State, claim: Fit, null: Fit) -> Hypothesis:
        """The hypothesis of tested effects, against the tire without them."""
        names = tuple(d.term.effect.identifier for d in decisions)
        return cls(names, state, claim, null, max(1.0, *(d.dispersion for d in decisions)))


def likeliest_refused(search: Search) -> Decision | None:
    """The likeliest effect that is in the likeliest set but not sure; None when there is none."""
    unsure = [d for d in search.last.refits if not (d.slight or d.term.effect.generic)]
    return max(unsure, key=lambda d: d.probability, default=None)


def hypothesis_of(search: Search) -> Hypothesis | None:
    """The hypothesis of the found effects, otherwise of the likeliest refused one; None without
    either."""
    first, last = search.steps[0].state, search.last
    if last.found:
        decisions = [f.decision for f in last.found]
        claim, null = last.state.whitened.fit, first.whitened.fit
    else:
        d = likeliest_refused(search)
        if d is None:
            return None
        decisions, null = [d], last.state.whitened.fit
        claim = last.state.with_term(d.term, most=4).fit
    return Hypothesis.of(decisions, last.state, claim, null)


def log_e(hypothesis: Hypothesis, data: TireRuns, rows: np.ndarray) -> float:
    """Logarithm of the e-value of new runs, `rows` of the data of all runs.

    Zero where the hypothesis does not apply to them; see `tire_is_determined_at`.
    """
    known = settings_of(hypothesis.state.runs)
    every = settings_of(data.runs)
    rows = np.array([r for r in rows if tire_is_determined_at(known, every[r])], dtype=int)
    if not len(rows):
        return 0.0
    claim, null = (
        _negative_log_density(hypothesis.state, fit, data, rows)
        for fit in (hypothesis.claim, hypothesis.null)
    )
    return (null - claim) / hypothesis.dispersion


def tire_is_determined_at(known: Sequence[Setting], other: Setting) -> bool:
    """Whether earlier runs determine the tire at a new setting: with its load, pressure and side
    slip, and with slips on both sides of its own. Elsewhere the law extrapolates, and its error
    would count as evidence."""
    slips = [s.kappa for s in known if s.condition == other.condition]
    return bool(slips) and min(slips) <= other.kappa <= max(slips)


def _negative_log_density(state: State, fit: Fit, data: TireRuns, rows: np.ndarray) -> float:
    """Negative log predictive density of the new runs for a fit of the old ones, without terms
    that are the same for all fits."""
    model = TireModel(data)
    model.take_references(state.model)
    model.parameters = state.model.parameters
    fitter = Fitter(model, state.fitter.weight)
    predicted = model.predict([fit.parameter_set()])[0]
    there = fitter.derivative(replace(fit, predicted=predicted))
    runs = data.runs.subset(rows)
    here = replace(there, predicted=predicted[:, rows], jacobian=there.jacobian[:, :, rows])
    metric = _metric(state, model, here, rows)
    loose = fit.loose()
    law = _law_error_columns(runs.condition, here.predicted)
    columns = np.concatenate([here.jacobian[loose], law])
    gram = metric.gram(runs.measured - here.predicted, columns)
    products, scores, energy = gram.total()
    known = np.zeros_like(products)
    n = len(loose)
    known[:n, :n] = _information(state, fit, loose)
    known[n:, n:] = np.eye(len(law)) / form_error_of(model).law ** 2
    both = known + products
    explained = float(scores @ np.linalg.solve(both, scores))
    grown = np.linalg.slogdet(both)[1] - np.linalg.slogdet(known)[1]
    return 0.5 * (energy - explained + grown)


def _law_error_columns(condition: np.ndarray, predicted: np.ndarray) -> np.ndarray:
    """Columns of the law's error: a factor on the first channel in each condition."""
    out = np.zeros((int(condition.max()) + 1, *predicted.shape))
    for c in range(len(out)):
        out[c, 0, condition == c] = predicted[0, condition == c]
    return out


def _metric(state: State, model: TireModel, here: Fit, rows: np.ndarray) -> Metric:
    """Metric with noise and scatter of the old runs, for the new ones."""
    old, runs = state.metric, model.runs.subset(rows)
    noises = [ChannelNoise(n.weights, np.ones(len(rows))) for n in old.whitener.noises]
    return Metric(make_whitener(runs, noises), scatter_columns(model, here), old.scatter)


def _information(state: State, fit: Fit, loose: list[int]) -> np.ndarray:
    """Information of the old runs and the priors on the parameters of a fit."""
    task = state.fitter.task(fit)
    _, width = priors(task.entries)
    residual = fit.residual(state.runs.measured)
    products = state.gram(residual, fit.jacobian[loose]).total()[0]
    own = np.maximum(np.asarray(width, dtype=float)[loose] ** -2.0, LEAST)
    return products + np.diag(own)


@dataclass(frozen=True)
class Evidence:
    """The product of the e-values of all batches so far."""

    log: float = 0.0
    batches: int = 0
    """number of batches with a hypothesis"""

    @classmethod
    def of(cls, answers: Iterable[Mapping[str, Any]]) -> Evidence:
        """The evidence of the answers in a log."""
        found = cls()
        for a in answers:
            found = found.with_batch(a["log_e"], bool(a["bet"]))
        return found

    def with_batch(self, log: float, betted: bool) -> Evidence:
        """The evidence with one more batch."""
        return Evidence(self.log + log, self.batches + betted)

    @property
    def e_value(self) -> float:
        """The e-value: 1/alpha or more refutes the tire alone at level alpha."""
        return math.exp(min(self.log, 700.0))

    @property
    def enough(self) -> bool:
        """Whether the e-value is large enough for a claim."""
        return self.log >= -math.log(ALPHA)


def e_value_words(log: float) -> str:
    """An e-value in words, from its logarithm."""
    if abs(log) < math.log(1e4):
        return f"e = {plain(math.exp(log))}"
    if abs(log) > MOST * math.log(10.0):
        return f"e > 10^{MOST}" if log > 0.0 else f"e < 10^-{MOST}"
    return f"e = 10^{log / math.log(10.0):.0f}"
