# SPDX-License-Identifier: Apache-2.0
"""What a model cannot imitate of the predictions of others, in present and planned runs together.

In units of the noise, with the scatter of the tire from run to run. The model is fitted to each of
the others in all runs, with everything that the posterior lets it imitate: its parameters, the
errors of law and transient, which runs of one law share, and the form errors of its effects.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flatplank_analysis.discovery.fit import Fit, Fitter, effect_contribution, whitened_priors
from flatplank_analysis.discovery.gram import Metric, solve
from flatplank_analysis.discovery.model import Model, ParameterSet, same_law
from flatplank_analysis.discovery.noise import make_whitener
from flatplank_analysis.discovery.state import State, scatter_columns
from flatplank_analysis.inference.errors import (
    FORMS,
    SHARED,
    LawErrors,
    effect_errors,
    shared_errors,
)
from flatplank_analysis.inference.weigh import Scales

SMALL = 1e-4
"""share of a direction of the scatter by which its derivative is computed"""
Name = tuple[int, str]


@dataclass(frozen=True)
class Part:
    """Sums of products of columns in noise units, over runs of one law: errors that only these
    runs have, the parameters of the model, then the differences of predictions from it."""

    law: Hashable
    own: int
    """number of the errors that only runs of this law have; each has a standard deviation of 1"""
    free: tuple[Name, ...]
    """parameters, as in `Fit.free`, and form errors that all runs share"""
    sums: np.ndarray
    """(columns, columns)"""

    def times(self, repeats: int) -> Part:
        """The sums of several equal runs."""
        return replace(self, sums=repeats * self.sums)

    def over(self, free: Sequence[Name]) -> np.ndarray:
        """The sums with these parameters, zero for those that the runs do not have."""
        at = {name: self.own + i for i, name in enumerate(free)}
        others = len(self.sums) - self.own - len(self.free)
        size = self.own + len(free) + others
        rows = [*range(self.own), *(at[n] for n in self.free), *range(size - others, size)]
        out = np.zeros((size, size))
        out[np.ix_(rows, rows)] = self.sums
        return out


def settled(parts: Sequence[Part], free: Sequence[Name]) -> np.ndarray:
    """Sums of runs of one law, over the parameters and the differences, with the errors that only
    these runs have integrated out."""
    own = parts[0].own
    sums = np.sum([part.over(free) for part in parts], axis=0)
    cross = sums[:own, own:]
    return sums[own:, own:] - cross.T @ np.linalg.solve(sums[:own, :own] + np.eye(own), cross)


class Contrast:
    """A model, and what it cannot imitate of predictions by others that may be true: it is fitted
    to each of them."""

    def __init__(self, scales: Scales, other: Fit, true: Sequence[ParameterSet]) -> None:
        """other: the model, a fit of the scales' runs; true: parameter sets of the others."""
        self.state, self.other, self.true = scales.state, other, tuple(true)
        self.errors, self.factor = LawErrors.of(scales.state), scales.metric.factor
        state = self.state
        predicted = state.model.predict(self.true)
        metric = state.metric.along(scatter_columns(state.model, other))
        self.old = self._parts(state.model, metric, other, predicted)
        self.priors = self._priors(state.fitter, other)
        self._settled = {
            part.law: Part(part.law, 0, part.free, settled([part], part.free)) for part in self.old
        }
        self.had = self.separations()

    def products(self, planned: Model) -> list[Part]:
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
        self.priors = self._priors(fitter, other) | self.priors
        metric = metric_of(self.state, planned, other)
        return self._parts(planned, metric, other, np.array(predicted))

    def separations(self, *planned: Part) -> np.ndarray:
        """Sum of squares of each difference that the model cannot imitate (others,), in the
        present and in planned runs together."""
        free = tuple(dict.fromkeys(n for part in (*self.old, *planned) for n in part.free))
        sums: np.ndarray | float = 0.0
        laws = dict.fromkeys(part.law for part in (*self.old, *planned))
        for law in laws:
            new = [part for part in planned if part.law == law]
            old = [part for part in self.old if part.law == law]
            sums = sums + (settled([*old, *new], free) if new else self._settled[law].over(free))
        assert isinstance(sums, np.ndarray)
        n = len(free)
        sums[range(n), range(n)] += [self.priors.get(name, 1.0) for name in free]
        cross = sums[:n, n:]
        step, _ = solve(sums[:n, :n], cross)
        return np.diag(sums)[n:] - np.einsum("ij,ij->j", cross, step)

    def gain(self, *planned: Part) -> np.ndarray:
        """Expected increase by planned runs of the sum of squares that the model leaves, for each
        of the others."""
        return np.maximum(self.separations(*planned) - self.had, 0.0)

    def _priors(self, fitter: Fitter, other: Fit) -> dict[Name, float]:
        """Inverse variances of the parameters that the runs of a fitter determine."""
        strength = whitened_priors(fitter.entries(other.terms))[1]
        return {other.free[i]: float(strength[i]) for i in other.loose()}

    def _parts(
        self, model: Model, metric: Metric, other: Fit, predicted: np.ndarray
    ) -> list[Part]:
        """Sums of the runs of a model, by law."""
        rows, effects = other.loose(), range(len(other.terms))
        forms = [FORMS[-1] * effect_errors(model, other, i) for i in effects]
        late = self.factor * SHARED[-1] * shared_errors(model, other.predicted)
        shared = [other.jacobian[rows], late, *forms]
        names = [other.free[i] for i in rows] + [(-2, f"late {k}") for k in range(len(late))]
        names += [(i, f"form {k}") for i, form in enumerate(forms) for k in range(len(form))]
        whole = [FORMS[-1] * effect_contribution(other, i)[None] for i in effects]
        local = [self.factor * self.errors.columns(model, other.predicted), *whole]
        own = sum(map(len, local))
        white = metric(np.concatenate([*local, *shared, predicted - other.predicted]))
        out = []
        for law, runs in same_law(model).items():
            flat = white[:, runs].reshape(len(white), -1)
            out.append(Part(law, own, tuple(names), flat @ flat.T))
        return out


def metric_of(state: State, planned: Model, fit: Fit) -> Metric:
    """The metric of noise and scatter for planned runs, with the noise of the present ones.

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
