# SPDX-License-Identifier: Apache-2.0
"""What a model cannot imitate of the predictions of others, in present and planned runs together.

In units of the noise, with the scatter of the tire from run to run; the model is fitted to each of
the others, in all runs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from flatplank_analysis.discovery.fit import Fit, Fitter, Term, whitened_priors
from flatplank_analysis.discovery.gram import Metric, solve
from flatplank_analysis.discovery.model import Model, ParameterSet
from flatplank_analysis.discovery.noise import make_whitener
from flatplank_analysis.discovery.state import State
from flatplank_analysis.discovery.steps import Search

SMALL = 1e-4
"""share of a direction of the scatter by which its derivative is computed"""


class Products(NamedTuple):
    """Sums of products of columns in noise units: the parameters of a model, then the differences
    of predictions from it."""

    free: tuple[tuple[int, str], ...]
    """parameters, as in `Fit.free`"""
    sums: np.ndarray
    """(columns, columns)"""

    def over(self, free: Sequence[tuple[int, str]]) -> np.ndarray:
        """The sums with these parameters, zero for those that the runs do not have."""
        at = {name: i for i, name in enumerate(free)}
        others = len(self.sums) - len(self.free)
        rows = [*(at[name] for name in self.free), *range(len(free), len(free) + others)]
        out = np.zeros((len(free) + others, len(free) + others))
        out[np.ix_(rows, rows)] = self.sums
        return out

    def times(self, repeats: int) -> Products:
        """The sums of several equal runs."""
        return Products(self.free, repeats * self.sums)


class Contrast:
    """A model, and what it cannot imitate of predictions by others that may be true: it is fitted
    to each of them."""

    def __init__(self, state: State, other: Fit, true: Sequence[ParameterSet]) -> None:
        """other: the model, a fit of the state's runs; true: parameter sets of the others."""
        self.state, self.other, self.true = state, other, tuple(true)
        predicted = state.model.predict(self.true)
        self.old = _products(state.fitter, state.metric, other, predicted)
        self.had = separations(self.old)

    @classmethod
    def of(cls, search: Search, index: int, rival: Term | None) -> Contrast:
        """A rival in the place of found effect `index` of a search, or the model without it; the
        model with the effect may be true."""
        last = search.last
        state, fit = last.state, last.state.whitened.fit
        place = len(fit.terms) - len(last.found) + index
        less = state.fitter.without_term(fit, place)
        other = state.fitter.with_term(less, rival) if rival else less
        return cls(state, other, [fit.parameter_set()])

    def products(self, planned: Model) -> Products:
        """Sums of planned runs, which may determine further parameters of the base."""
        own = [p.name for p in self.state.model.parameters]

        def base_of(values: np.ndarray) -> np.ndarray:
            known = dict(zip(own, values, strict=True))
            return np.array([known.get(p.name, p.null) for p in planned.parameters])

        fitter = Fitter(planned, np.ones((1, 1, 1)))
        bare = replace(self.other, base=base_of(self.other.base))
        task = fitter.task(bare)
        first, *predicted = planned.predict(
            [bare.parameter_set(), *(replace(t, base=base_of(t.base)) for t in self.true)]
        )
        other = fitter.derivative(replace(bare, predicted=first, free=task.free, known=task.known))
        metric = metric_of(self.state, planned, other)
        return _products(fitter, metric, other, np.array(predicted), self.old.free)

    def gain(self, *runs: Products) -> np.ndarray:
        """Expected increase by planned runs of the sum of squares that the model leaves, for each
        of the others."""
        return np.maximum(separations(self.old, *runs) - self.had, 0.0)


def _products(
    fitter: Fitter, metric: Metric, other: Fit, predicted: np.ndarray,
    known: Sequence[tuple[int, str]] = (),
) -> Products:  # fmt: skip
    """Sums of runs, with the priors of the parameters that are not `known` from other runs."""
    rows = other.loose()
    free = tuple(other.free[i] for i in rows)
    columns = np.concatenate([other.jacobian[rows], predicted - other.predicted])
    white = metric(columns).reshape(len(columns), -1)
    sums = white @ white.T
    strength = whitened_priors(fitter.entries(other.terms))[1][rows]
    new = [i for i, name in enumerate(free) if name not in known]
    sums[new, new] += strength[new]
    return Products(free, sums)


def separations(*parts: Products) -> np.ndarray:
    """Sum of squares of each difference that the model cannot imitate in all runs (others,)."""
    free = tuple(dict.fromkeys(name for part in parts for name in part.free))
    sums = np.sum([part.over(free) for part in parts], axis=0)
    n = len(free)
    cross = sums[:n, n:]
    step, _ = solve(sums[:n, :n], cross)
    return np.diag(sums)[n:] - np.einsum("ij,ij->j", cross, step)


def metric_of(state: State, planned: Model, fit: Fit) -> Metric:
    """The metric of the decisions for planned runs, with the noise of the present ones.

    fit: of the planned runs.
    """
    runs = planned.runs
    usual = [
        replace(noise, scale=np.full(runs.runs, np.median(noise.scale)))
        for noise in state.metric.whitener.noises
    ]
    at = {p.name: i for i, p in enumerate(planned.parameters)}
    sets = []
    for direction in planned.scatter_directions(fit.base):
        moved = fit.base.copy()
        for name, amount in direction.items():
            moved[at[name]] += SMALL * amount
        sets.append(replace(fit.parameter_set(), base=moved))
    directions = (planned.predict(sets) - fit.predicted) / SMALL
    return Metric(make_whitener(runs, usual), directions, state.metric.scatter)
