# SPDX-License-Identifier: Apache-2.0
"""Error in conditions that were not used for the sizes of the effects.

The sizes come from the other conditions. The base is fitted to all, because leaving out the
largest slip would test how the law extrapolates. Priors and ranges hold as in the fit; without
them the base would lower the error beside any effect. So the number is comparable with the error
of the fit, and equal to it without effects.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import lsq_linear

from flatplank_analysis.discovery.fit import Fit, doubling_step
from flatplank_analysis.discovery.state import State


def gain(state: State, fit: Fit, index: int) -> float:
    """Share of the squared error [floors] that an effect removes where it was not fitted."""
    in_floors = np.array([1.0 / max(f.floor, 1e-12) for f in state.floors])[:, None, None]
    without, with_, _ = _errors(state, fit, [index], in_floors)
    return float(1.0 - with_ / max(without, 1e-30))


def rmse(state: State) -> float:
    """Held-out error of the first channel; without effects the error of the fit."""
    fitted = state.runs.rmse(state.residual[0])
    effects = range(len(state.fit.terms))
    if not effects:
        return fitted
    first = np.zeros((len(state.floors), 1, 1))
    first[0] = 1.0
    _, with_, same = _errors(state, state.fit, effects, first)
    # a further linear step of the base is no merit of the effects, nor is a gain of one channel
    # at the cost of another
    return float(np.sqrt(fitted**2 + max(with_ - same, 0.0) / state.residual[0].size))


def _errors(
    state: State, fit: Fit, effects: Sequence[int], weight: np.ndarray
) -> tuple[float, float, float]:
    """Squared errors without effects, with sizes from the other conditions, and as fitted.

    weight (channels, 1, 1) is for the errors; the sizes are found with the weights of the fit.
    """
    form = _QuadraticForm(state, fit, effects)
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


class _QuadraticForm:
    """Quadratic form of a fit's sum of squares.

    Its variables are changes from the fit: of the base, then of the size of each effect, relative
    to its fitted size (-1: no effect).
    """

    def __init__(self, state: State, fit: Fit, effects: Sequence[int]) -> None:
        self.state, self.fit = state, fit
        rest = [i for i, (owner, _) in enumerate(fit.free) if owner not in effects]
        self.count = len(rest)
        turn = np.concatenate(
            [np.eye(len(fit.free))[rest], [doubling_step(fit, index) for index in effects]]
        )
        self.columns = np.tensordot(turn, fit.jacobian, axes=1)
        self.residual = fit.residual(state.runs.measured)
        fitter = state.fitter
        task = fitter.task(fit)
        z = task.pack(fit.base, fit.terms)
        self.low, self.high = _step_limits(turn, task.lower - z, task.upper - z)
        centre, strength = fitter.centres_and_weights(task.entries)
        self.groups = self.sums(fitter.weight)
        self.hessian = sum(g[0] for g in self.groups) + (turn * strength) @ turn.T
        self.slope = sum(g[1] for g in self.groups) - turn @ (strength * (z - centre))
        self.scale = np.sqrt(np.maximum(np.diag(self.hessian), 1e-30))
        """square root of the diagonal of the Hessian, for scaling"""

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
        """Sizes of the effects without one condition, relative to the fit; -1 (no effect) where no
        other condition determines them.
        """
        n, (products, scores, _) = self.count, one
        hessian, slope = self.hessian.copy(), self.slope.copy()
        hessian[n:] -= products[n:]
        hessian[:n, n:] -= products[:n, n:]
        slope[n:] -= scores[n:]
        # measured from the size of no effect, so that undetermined sizes stay there
        none = np.concatenate([np.zeros(n), np.ones(len(slope) - n)])
        low, high = self.low + none, self.high + none
        return _least(hessian, slope + hessian @ none, low, high, self.scale)[n:] - 1.0

    def base_for(self, sizes: np.ndarray) -> np.ndarray:
        """All variables, with the base fitted to all conditions for given sizes."""
        n = self.count
        slope = self.slope[:n] - self.hessian[:n, n:] @ sizes
        base = _least(self.hessian[:n, :n], slope, self.low[:n], self.high[:n], self.scale[:n])
        return np.concatenate([base, sizes])


def _step_limits(
    turn: np.ndarray, low: np.ndarray, high: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Largest negative and positive step of each combination until a parameter meets its range."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = np.stack([low / turn, high / turn])
    moved = turn != 0.0
    down = np.where(moved, ends.min(axis=0), -np.inf).max(axis=1)
    up = np.where(moved, ends.max(axis=0), np.inf).min(axis=1)
    return np.minimum(down, 0.0), np.maximum(up, 0.0)


def _least(
    hessian: np.ndarray, slope: np.ndarray, low: np.ndarray, high: np.ndarray, scale: np.ndarray
) -> np.ndarray:
    """The x within its range that minimises x'Hx/2 - g'x; 0 where H does not determine x."""
    values, vectors = np.linalg.eigh(hessian / np.outer(scale, scale))
    root = np.sqrt(np.maximum(values, 1e-9 * values[-1]))
    goal = (vectors.T @ (slope / scale)) / root
    # the solver needs a gap between the bounds
    bounds = (low * scale - 1e-12, high * scale + 1e-12)
    return lsq_linear(root[:, None] * vectors.T, goal, bounds, method="bvls").x / scale
