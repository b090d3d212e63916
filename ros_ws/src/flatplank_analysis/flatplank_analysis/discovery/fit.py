# SPDX-License-Identifier: Apache-2.0
"""Plain and whitened fits of a model and its effects.

The drawn fit and its error come from plain least squares; decisions and sizes come from the
whitened fit. The runs with the largest forces dominate the plain fit; the whitened one weighs
every run by its scatter, so that its sizes are two to three times more precise. One linear step
from the plain fit is no substitute: its error in chi2 is as large as the drop by a weak effect.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flatplank_analysis.discovery.descent import Problem, descend
from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.model import Model, ParameterSet
from flatplank_analysis.discovery.parameters import Parameter

TOLERANCE = 2e-5
"""relative decrease of the sum of squares below which the plain fit ends"""
ENOUGH = 0.5
"""decrease of the whitened chi2 below which the whitened fit ends"""


@dataclass(frozen=True)
class Term:
    """An effect in a model, with its parameter values."""

    effect: type[Effect]
    values: np.ndarray
    fixed: tuple[str, ...] = ()
    """parameters that are not fitted"""

    def named(self) -> dict[str, float]:
        names = [p.name for p in self.effect.parameters()]
        return dict(zip(names, (float(v) for v in self.values), strict=True))

    @property
    def size(self) -> float:
        return float(self.effect.size(self.named()))


@dataclass(frozen=True)
class Fit:
    """A fitted model: base, terms, predictions, Jacobian."""

    base: np.ndarray
    terms: tuple[Term, ...]
    predicted: np.ndarray
    """(channels, runs, samples)"""
    chi2: float
    """weighted sum of squares with the priors"""
    jacobian: np.ndarray
    """(free parameters, channels, runs, samples), in the scale of the parameters"""
    free: tuple[tuple[int, str], ...] = ()
    """rows of the Jacobian: (-1, base parameter) or (term, parameter)"""
    at_bound: tuple[str, ...] = ()
    """names of the parameters at an end of their range"""
    known: tuple[int, ...] = ()
    """rows of the Jacobian of parameters with a narrow known range (`Parameter.known`)"""

    def loose(self) -> list[int]:
        """Rows of the Jacobian that may imitate an effect: all but the `known` ones."""
        return [i for i in range(len(self.free)) if i not in self.known]

    def residual(self, measured: np.ndarray) -> np.ndarray:
        return measured - self.predicted

    def parameter_set(self) -> ParameterSet:
        return ParameterSet(self.base, tuple((t.effect, t.values) for t in self.terms))


@dataclass(frozen=True)
class _Entry:
    term: int
    parameter: Parameter

    @property
    def scale(self) -> float:
        return scale_of(self.parameter)

    def at_end(self, value: float) -> bool:
        return self.parameter.at_end(value, 1e-6 * self.scale)


def scale_of(p: Parameter) -> float:
    """The unit in which a parameter is fitted: its screening step, or a share of its range."""
    if p.screen:
        return abs(p.screen)
    width = p.upper - p.lower
    return 0.02 * width if np.isfinite(width) else max(abs(p.null), 1.0)


def doubling_step(fit: Fit, index: int) -> np.ndarray:
    """Change of the free parameters, in their scale, when effect `index` doubles."""
    term = fit.terms[index]
    named = term.named()
    linear = {p.name: p for p in term.effect.linear()}
    out = np.zeros(len(fit.free))
    for row, (owner, name) in enumerate(fit.free):
        if owner == index and name in linear:
            p = linear[name]
            out[row] = (named[name] - p.null) / scale_of(p)
    return out


def effect_contribution(fit: Fit, index: int) -> np.ndarray:
    """Change of the prediction when the effect doubles (channels, runs, samples)."""
    return np.tensordot(doubling_step(fit, index), fit.jacobian, axes=1)


class Fitter:
    """Weighted least squares of a model and its terms; `weight` (channels, 1, 1)."""

    def __init__(self, model: Model, weight: np.ndarray) -> None:
        self.model = model
        self.weight = weight

    def entries(self, terms: Sequence[Term]) -> list[_Entry]:
        """All fitted parameters, base first."""
        out = [_Entry(-1, p) for p in self.model.parameters if p.screen]
        for i, term in enumerate(terms):
            out += [_Entry(i, p) for p in term.effect.parameters() if p.name not in term.fixed]
        return out

    def fit(
        self,
        base: np.ndarray,
        terms: Sequence[Term] = (),
        iterations: int = 25,
        known: Fit | None = None,
    ) -> Fit:
        """Fit from the given start; every iteration lowers the sum of squares, or the fit ends.

        known: a fit of the same terms nearby, whose Jacobian is used for the first steps.
        """
        task = Task(self, base, terms)
        centre, strength = self.centres_and_weights(task.entries)
        problem = Problem(
            self.model.runs.measured,
            lambda points: self.model.predict([task.parameter_set(z) for z in points]),
            lambda z, predicted: self.columns(z, predicted, task),
            lambda values: values * self.weight,
            lambda chi2: TOLERANCE * chi2,
            task.lower, task.upper, centre, strength,
        )  # fmt: skip
        begin = task.pack(base, terms)
        end = descend(problem, begin, known.jacobian if known else None, iterations)
        z, predicted, chi2 = end.point
        columns = end.columns if end.fresh else self.columns(z, predicted, task)
        bound = tuple(
            e.parameter.name
            for e, v in zip(task.entries, z * [e.scale for e in task.entries], strict=True)
            if e.at_end(v)
        )
        return Fit(*task.unpack(z), predicted, chi2, columns, task.free, bound, task.known)

    def error(self, fit: Fit) -> float:
        """Weighted root of the sum of squares of a fit's residual, without priors."""
        return float(np.linalg.norm(fit.residual(self.model.runs.measured) * self.weight))

    def derivative(self, fit: Fit) -> Fit:
        """The same fit with a newly computed Jacobian."""
        task = self.task(fit)
        z = task.pack(fit.base, fit.terms)
        return replace(fit, jacobian=self.columns(z, fit.predicted, task))

    def task(self, fit: Fit) -> Task:
        return Task(self, fit.base, fit.terms)

    def with_term(self, fit: Fit, term: Term) -> Fit:
        """A fit with one more term at its start values: rows of the Jacobian are added."""
        terms = (*fit.terms, term)
        task = Task(self, fit.base, terms)
        z = task.pack(fit.base, terms)
        predicted = self.model.predict([task.parameter_set(z)])[0]
        new = list(range(len(fit.free), len(z)))
        rows = self.columns(z, predicted, task, new)
        columns = np.concatenate([fit.jacobian, rows])
        return replace(fit, terms=terms, predicted=predicted, jacobian=columns, free=task.free)

    def without_term(self, fit: Fit, index: int) -> Fit:
        """A fit without one of its terms; nothing else changes."""
        keep = [i for i, (owner, _) in enumerate(fit.free) if owner != index]
        terms = tuple(t for i, t in enumerate(fit.terms) if i != index)
        task = Task(self, fit.base, terms)
        predicted = self.model.predict([task.parameter_set(task.pack(fit.base, terms))])[0]
        return replace(
            fit, terms=terms, predicted=predicted, jacobian=fit.jacobian[keep], free=task.free,
            known=task.known,
        )  # fmt: skip

    def centres_and_weights(self, entries: Sequence[_Entry]) -> tuple[np.ndarray, np.ndarray]:
        """Centres of the priors and their weights in chi2: that of a tenth of the samples of one
        channel."""
        centre, width = priors(entries)
        samples = 0.01 * self.model.runs.measured[0].size * float(self.weight.max() ** 2) * 10.0
        return centre, samples / width**2

    def prior_terms(self, fit: Fit, rows: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
        """Strength (k,) of the priors of some rows of a fit's Jacobian in the whitened sum of
        squares, and their scores (k,) at the fit."""
        task = self.task(fit)
        centre, strength = whitened_priors(task.entries)
        return strength[rows], (strength * (centre - task.pack(fit.base, fit.terms)))[rows]

    def columns(
        self, z: np.ndarray, predicted: np.ndarray, task: Task, rows: Sequence[int] | None = None
    ) -> np.ndarray:
        """Derivatives of the prediction at a point, for all parameters or for some rows."""
        rows = range(len(z)) if rows is None else rows
        sets, steps = [], []
        for i in rows:
            steps.append(-1e-3 if z[i] + 1e-3 > task.upper[i] else 1e-3)
            moved = z.copy()
            moved[i] += steps[-1]
            sets.append(task.parameter_set(moved))
        columns = self.model.predict(sets)
        columns -= predicted
        columns /= np.array(steps)[:, None, None, None]
        return columns


def priors(entries: Sequence[_Entry]) -> tuple[np.ndarray, np.ndarray]:
    """Centres and widths of the priors, in the scale of the parameters."""
    centre = np.array([e.parameter.null / e.scale for e in entries])
    return centre, np.array([e.parameter.prior / e.scale for e in entries])


def whitened_priors(entries: Sequence[_Entry]) -> tuple[np.ndarray, np.ndarray]:
    """Centres of the priors and their weights in the whitened sum of squares."""
    centre, width = priors(entries)
    return centre, width**-2.0


class Task:
    """The scaled parameter vector of one fit, and its conversion into a parameter set."""

    def __init__(self, fitter: Fitter, base: np.ndarray, terms: Sequence[Term]) -> None:
        self.entries = fitter.entries(terms)
        self.base = np.array(base, dtype=float)
        self.terms = tuple(terms)
        self.lower = np.array([e.parameter.lower / e.scale for e in self.entries])
        self.upper = np.array([e.parameter.upper / e.scale for e in self.entries])
        self.free = tuple((e.term, e.parameter.name) for e in self.entries)
        """rows of a Jacobian: (-1, base parameter) or (term, parameter)"""
        self.known = tuple(i for i, e in enumerate(self.entries) if e.parameter.known)
        self._at = {p.name: i for i, p in enumerate(fitter.model.parameters)}

    def pack(self, base: np.ndarray, terms: Sequence[Term]) -> np.ndarray:
        named = [t.named() for t in terms]
        first = dict(zip(self._at, base, strict=True))
        return np.array(
            [(named[e.term] if e.term >= 0 else first)[e.parameter.name] / e.scale
             for e in self.entries]
        )  # fmt: skip

    def unpack(self, z: np.ndarray) -> tuple[np.ndarray, tuple[Term, ...]]:
        one = self.parameter_set(z)
        pairs = zip(self.terms, one.effects, strict=True)
        return one.base, tuple(replace(t, values=values) for t, (_, values) in pairs)

    def parameter_set(self, z: np.ndarray) -> ParameterSet:
        base = self.base.copy()
        named = [t.named() for t in self.terms]
        for value, e in zip(z, self.entries, strict=True):
            if e.term < 0:
                base[self._at[e.parameter.name]] = value * e.scale
            else:
                named[e.term][e.parameter.name] = value * e.scale
        pairs = zip(self.terms, named, strict=True)
        return ParameterSet(base, tuple((t.effect, t.effect.vector(n)) for t, n in pairs))


@dataclass(frozen=True)
class Whitened:
    """A fit at the smallest whitened chi2, and that chi2 including the priors."""

    fit: Fit
    chi2: float


def fit_whitened(
    metric: Callable[[np.ndarray], np.ndarray], fitter: Fitter, fit: Fit, most: int = 12
) -> Whitened:
    """Minimise the whitened chi2 from a fit, with `most` Jacobians including that of the fit.

    metric: converts values (n, channels, runs, samples) to noise units; see `gram.Metric`.
    Parameters that are `known`, and so may not imitate an effect, are not changed.
    """
    task, loose = fitter.task(fit), fit.loose()
    begin = task.pack(fit.base, fit.terms)

    def full_vector(z: np.ndarray) -> np.ndarray:
        """The full parameter vector with the free part set to z."""
        out = begin.copy()
        out[loose] = z
        return out

    centre, strength = whitened_priors(task.entries)
    problem = Problem(
        fitter.model.runs.measured,
        lambda points: fitter.model.predict([task.parameter_set(full_vector(z)) for z in points]),
        lambda z, predicted: fitter.columns(full_vector(z), predicted, task, loose),
        metric,
        lambda _chi2: ENOUGH,
        task.lower[loose], task.upper[loose], centre[loose], strength[loose],
    )  # fmt: skip
    end = descend(problem, begin[loose], fit.jacobian[loose], jacobians=most - 1)
    base, terms = task.unpack(full_vector(end.point.z))
    columns = fit.jacobian.copy()
    columns[loose] = end.columns
    found = replace(fit, base=base, terms=terms, predicted=end.point.predicted, jacobian=columns)
    return Whitened(found, end.point.energy)
