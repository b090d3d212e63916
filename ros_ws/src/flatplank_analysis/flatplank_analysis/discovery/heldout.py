# SPDX-License-Identifier: Apache-2.0
"""The error in conditions that did not fix the sizes of the effects.

The sizes come from the other conditions; the base is fitted to all, since leaving out the largest
slip would test how the law extrapolates. Priors and ranges hold as in the fit: a base that is
freed of them lowers the error beside any effect. So the number stands beside that of the fit, and
without effects it is the same.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import lsq_linear

from flatplank_analysis.discovery.fit import Fit, growth
from flatplank_analysis.discovery.state import State


def gain(state: State, fit: Fit, index: int) -> float:
    """Share of the squared error, in floors, that an effect removes where it was not fitted."""
    in_floors = np.array([1.0 / max(f.floor, 1e-12) for f in state.floors])[:, None, None]
    without, with_, _ = _errors(state, fit, [index], in_floors)
    return float(1.0 - with_ / max(without, 1e-30))


def rmse(state: State) -> float:
    """Error of the first channel with all effects of a fit; that of the fit without effects."""
    fitted = state.runs.rmse(state.residual[0])
    effects = range(len(state.fit.terms))
    if not effects:
        return fitted
    first = np.zeros((len(state.floors), 1, 1))
    first[0] = 1.0
    _, with_, same = _errors(state, state.fit, effects, first)
    # what the base would still gain by one linear step is no merit of the effects, nor is what
    # one channel gains at the cost of another
    return float(np.sqrt(fitted**2 + max(with_ - same, 0.0) / state.residual[0].size))


def _errors(
    state: State, fit: Fit, effects: Sequence[int], weight: np.ndarray
) -> tuple[float, float, float]:
    """Squared error without effects, with sizes of the other conditions, and as fitted.

    weight (channels, 1, 1) is that of the judge; the sizes are found with the weights of the fit.
    """
    form = _Form(state, fit, effects)
    n = len(effects)
    judged = form.sums(weight)
    without = form.base_for(np.full(n, -1.0))
    same = form.base_for(np.zeros(n))
    errors = np.zeros(3)
    for one, held in zip(form.groups, judged, strict=True):
        with_ = form.base_for(form.sizes_without(one))
        for i, x in enumerate((without, with_, same)):
            products, scores, energy = held
            errors[i] += energy - 2.0 * x @ scores + x @ products @ x
    return float(errors[0]), float(errors[1]), float(errors[2])


class _Form:
    """A fit's sum of squares near its end; numbers: the base, then each effect in own sizes."""

    def __init__(self, state: State, fit: Fit, effects: Sequence[int]) -> None:
        self.state, self.fit = state, fit
        rest = [i for i, (owner, _) in enumerate(fit.free) if owner not in effects]
        self.count = len(rest)
        turn = np.concatenate(
            [np.eye(len(fit.free))[rest], [growth(fit, index) for index in effects]]
        )
        self.columns = np.tensordot(turn, fit.jacobian, axes=1)
        self.residual = fit.residual(state.runs.measured)
        fitter = state.fitter
        task = fitter.task(fit)
        z = task.pack(fit.base, fit.terms)
        self.low, self.high = _room(turn, task.lower - z, task.upper - z)
        centre, strength = fitter.known_before(task.entries)
        self.groups = self.sums(fitter.weight)
        self.hessian = sum(g[0] for g in self.groups) + (turn * strength) @ turn.T
        self.slope = sum(g[1] for g in self.groups) - turn @ (strength * (z - centre))
        self.usual = np.sqrt(np.maximum(np.diag(self.hessian), 1e-30))
        """of every number, in all conditions: the inverse of what it can be known to"""

    def sums(self, weight: np.ndarray) -> list[tuple[np.ndarray, np.ndarray, float]]:
        """Per condition: products of the columns, of columns and residual, of the residual."""
        columns = self.columns * weight
        residual = self.residual * weight
        out = []
        for rows in self.state.runs.groups:
            flat = columns[:, :, rows].reshape(len(columns), -1)
            e = residual[:, rows].reshape(-1)
            out.append((flat @ flat.T, flat @ e, float(e @ e)))
        return out

    def sizes_without(self, one: tuple[np.ndarray, np.ndarray, float]) -> np.ndarray:
        """Sizes of the effects when a condition says nothing of them; -1, the size of none, where
        no other does.
        """
        n, (products, scores, _) = self.count, one
        hessian, slope = self.hessian.copy(), self.slope.copy()
        hessian[n:] -= products[n:]
        hessian[:n, n:] -= products[:n, n:]
        slope[n:] -= scores[n:]
        # counted from the size of none: what nothing determines stays there
        none = np.concatenate([np.zeros(n), np.ones(len(slope) - n)])
        low, high = self.low + none, self.high + none
        return _least(hessian, slope + hessian @ none, low, high, self.usual)[n:] - 1.0

    def base_for(self, sizes: np.ndarray) -> np.ndarray:
        """All numbers, the base fitted to all conditions beside given sizes."""
        n = self.count
        slope = self.slope[:n] - self.hessian[:n, n:] @ sizes
        base = _least(self.hessian[:n, :n], slope, self.low[:n], self.high[:n], self.usual[:n])
        return np.concatenate([base, sizes])


def _room(turn: np.ndarray, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How far each combination of numbers may go down and up until one meets its range."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = np.stack([low / turn, high / turn])
    moved = turn != 0.0
    down = np.where(moved, ends.min(axis=0), -np.inf).max(axis=1)
    up = np.where(moved, ends.max(axis=0), np.inf).min(axis=1)
    return np.minimum(down, 0.0), np.maximum(up, 0.0)


def _least(
    hessian: np.ndarray, slope: np.ndarray, low: np.ndarray, high: np.ndarray, scale: np.ndarray
) -> np.ndarray:
    """The x within its range where x'Hx/2 - g'x is smallest; 0 where H says nothing of x."""
    values, vectors = np.linalg.eigh(hessian / np.outer(scale, scale))
    root = np.sqrt(np.maximum(values, 1e-9 * values[-1]))
    goal = (vectors.T @ (slope / scale)) / root
    # the solver wants room between the ends
    bounds = (low * scale - 1e-12, high * scale + 1e-12)
    return lsq_linear(root[:, None] * vectors.T, goal, bounds, method="bvls").x / scale
