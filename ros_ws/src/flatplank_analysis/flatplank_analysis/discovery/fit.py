# SPDX-License-Identifier: Apache-2.0
"""Bounded Gauss-Newton with lanes: one call computes the Jacobian, one the line search."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.model import Lane, Model
from flatplank_analysis.discovery.parameters import Parameter

STEPS = (1.0, 0.5, 0.2, 0.05)
"""step lengths tried at once"""


@dataclass(frozen=True)
class Term:
    """An effect in a model: which one, with which parameter values."""

    effect: type[Effect]
    values: np.ndarray
    fixed: tuple[str, ...] = ()
    """parameters that are not fitted"""

    def named(self) -> dict[str, float]:
        """Values by parameter name."""
        names = [p.name for p in self.effect.parameters()]
        return dict(zip(names, (float(v) for v in self.values), strict=True))

    @property
    def size(self) -> float:
        """Reported size."""
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
    jacobian: np.ndarray | None
    """(free parameters, channels, runs, samples), in the scale of the parameters"""
    free: tuple[tuple[int, str], ...] = ()
    """what the rows of the Jacobian are: (-1, base parameter) or (term, parameter)"""
    at_bound: tuple[str, ...] = ()
    iterations: int = 0

    def residual(self, measured: np.ndarray) -> np.ndarray:
        """Measured minus predicted."""
        return measured - self.predicted

    def lane(self) -> Lane:
        """The lane that predicts this."""
        return Lane(self.base, tuple((t.effect, t.values) for t in self.terms))


@dataclass(frozen=True)
class _Entry:
    term: int
    parameter: Parameter

    @property
    def scale(self) -> float:
        p = self.parameter
        if p.screen:
            return abs(p.screen)
        width = p.upper - p.lower
        return 0.02 * width if np.isfinite(width) else max(abs(p.null), 1.0)


class Fitter:
    """Weighted least squares of a model and its terms; `weight` (channels, runs, samples)."""

    def __init__(self, model: Model, weight: np.ndarray) -> None:
        self.model = model
        self.weight = weight * model.runs.used

    def entries(self, terms: Sequence[Term]) -> list[_Entry]:
        """All fitted numbers, base first."""
        out = [_Entry(-1, p) for p in self.model.parameters if p.screen]
        for i, term in enumerate(terms):
            out += [_Entry(i, p) for p in term.effect.parameters() if p.name not in term.fixed]
        return out

    def fit(
        self,
        base: np.ndarray,
        terms: Sequence[Term] = (),
        iterations: int = 12,
        tolerance: float = 2e-5,
        jacobian: bool = True,
    ) -> Fit:
        """Fit from the given start; every iteration lowers the sum of squares or ends."""
        entries = self.entries(terms)
        lower = np.array([e.parameter.lower / e.scale for e in entries])
        upper = np.array([e.parameter.upper / e.scale for e in entries])
        z = np.clip(self._pack(base, terms, entries), lower, upper)
        lane = self._lane(z, base, terms, entries)
        predicted = self.model.predict([lane])[0]
        chi2 = self._chi2(predicted, z, entries)
        damping, done, columns, count = 1e-6, False, None, 0
        for count in range(iterations):
            columns = self._jacobian(z, predicted, base, terms, entries, lower, upper)
            moves = self._moves(columns, predicted, z, entries, lower, upper, damping)
            lanes = [self._lane(zz, base, terms, entries) for zz in moves]
            tried = self.model.predict(lanes)
            values = [self._chi2(t, zz, entries) for t, zz in zip(tried, moves, strict=True)]
            best = int(np.nanargmin(values)) if np.isfinite(values).any() else 0
            gain = chi2 - values[best]
            if not gain > 0.0:
                if damping > 1.0:
                    done = True
                    break
                damping = max(damping, 1e-5) * 100.0
                continue
            damping = max(damping * 0.1, 1e-7)
            z, predicted, chi2 = moves[best], tried[best], values[best]
            if gain < tolerance * chi2:
                break
        if jacobian and not done:
            columns = self._jacobian(z, predicted, base, terms, entries, lower, upper)
        return self._result(z, base, terms, entries, predicted, chi2, columns, count + 1)

    def derivative(self, fit: Fit) -> Fit:
        """The same fit with its Jacobian made afresh."""
        entries = self.entries(fit.terms)
        lower = np.array([e.parameter.lower / e.scale for e in entries])
        upper = np.array([e.parameter.upper / e.scale for e in entries])
        z = self._pack(fit.base, fit.terms, entries)
        columns = self._jacobian(z, fit.predicted, fit.base, fit.terms, entries, lower, upper)
        return replace(fit, jacobian=columns)

    def _result(self, z, base, terms, entries, predicted, chi2, columns, count) -> Fit:
        lane = self._lane(z, base, terms, entries)
        new = tuple(replace(t, values=v) for t, (_, v) in zip(terms, lane.effects, strict=True))
        bound = tuple(
            e.parameter.name
            for e, v in zip(entries, z, strict=True)
            if min(v * e.scale - e.parameter.lower, e.parameter.upper - v * e.scale)
            < 1e-6 * e.scale
        )
        free = tuple((e.term, e.parameter.name) for e in entries)
        return Fit(lane.base, new, predicted, chi2, columns, free, bound, count)

    def _pack(self, base, terms, entries) -> np.ndarray:
        names = {p.name: i for i, p in enumerate(self.model.parameters)}
        out = []
        for e in entries:
            if e.term < 0:
                value = base[names[e.parameter.name]]
            else:
                value = terms[e.term].named()[e.parameter.name]
            out.append(value / e.scale)
        return np.array(out)

    def _lane(self, z, base, terms, entries) -> Lane:
        base = np.array(base, dtype=float)
        names = {p.name: i for i, p in enumerate(self.model.parameters)}
        named = [t.named() for t in terms]
        for value, e in zip(z, entries, strict=True):
            if e.term < 0:
                base[names[e.parameter.name]] = value * e.scale
            else:
                named[e.term][e.parameter.name] = value * e.scale
        return Lane(
            base, tuple((t.effect, t.effect.vector(n)) for t, n in zip(terms, named, strict=True))
        )

    def _priors(self, entries) -> tuple[np.ndarray, np.ndarray]:
        centre = np.array([e.parameter.null / e.scale for e in entries])
        width = np.array([e.parameter.prior / e.scale for e in entries])
        return centre, self._prior_weight / width**2

    @property
    def _prior_weight(self) -> float:
        """A prior counts like a hundredth of the samples of one channel per unit variance."""
        return 0.01 * self.model.runs.used.sum() * float(self.weight.max() ** 2) * 10.0

    def _chi2(self, predicted, z, entries) -> float:
        centre, strength = self._priors(entries)
        e = (self.model.runs.measured - predicted) * self.weight
        return float(np.sum(e * e) + np.sum(strength * (z - centre) ** 2))

    def _jacobian(self, z, predicted, base, terms, entries, lower, upper) -> np.ndarray:
        steps = np.full(len(z), 1e-3)
        steps = np.where(z + steps > upper, -steps, steps)
        lanes = []
        for i, h in enumerate(steps):
            moved = z.copy()
            moved[i] += h
            lanes.append(self._lane(moved, base, terms, entries))
        columns = self.model.predict(lanes)
        columns -= predicted
        columns /= steps[:, None, None, None]
        return columns

    def _moves(self, columns, predicted, z, entries, lower, upper, damping) -> list[np.ndarray]:
        """End points of several step lengths, the active bounds held."""
        flat = (columns * self.weight).reshape(len(z), -1)
        e = ((self.model.runs.measured - predicted) * self.weight).reshape(-1)
        centre, strength = self._priors(entries)
        hessian = flat @ flat.T + np.diag(strength)
        slope = flat @ e - strength * (z - centre)
        step = bounded_step(hessian, slope, lower - z, upper - z, damping)
        return [np.clip(z + s * step, lower, upper) for s in STEPS]


def bounded_step(hessian, slope, lower, upper, damping: float) -> np.ndarray:
    """Minimise x'Hx/2 - g'x within a box by holding, one after the other, what leaves it."""
    size = len(slope)
    scale = np.sqrt(np.maximum(np.diag(hessian), 1e-30))
    work = hessian / np.outer(scale, scale) + (damping + 1e-9) * np.eye(size)
    goal, low, high = slope / scale, lower * scale, upper * scale
    x = np.zeros(size)
    held = np.zeros(size, dtype=bool)
    for _ in range(size + 1):
        free = ~held
        if not free.any():
            break
        right = goal[free] - work[np.ix_(free, held)] @ x[held]
        x[free] = np.linalg.solve(work[np.ix_(free, free)], right)
        out = free & ((x < low) | (x > high))
        if not out.any():
            break
        x[out] = np.clip(x[out], low[out], high[out])
        held |= out
    return x / scale
