# SPDX-License-Identifier: Apache-2.0
"""Bounded least squares on lanes: every Jacobian column is a lane of one model call.

Levenberg-Marquardt steps in scaled variables; several damping values are tried as lanes of one
call. A variable that rests on its bound and wants to go through it is left out of the step.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

Residuals = Callable[[np.ndarray], np.ndarray]
"""Parameters (lanes, p) -> weighted residuals (lanes, n)."""

STEP = 1e-4
"""Relative step of the central differences: above the grain of a tabulated law."""
DAMPING = np.array([1e-3, 1e-1, 1.0, 1e1, 1e3])
"""Tried together, times the current damping."""
SAME = 0.02
"""Trials closer to the boldest one than this share of its step are not tried beside it."""


@dataclass(frozen=True)
class Solution:
    """Where the search ended: x (p,), residual (n,), Jacobian (n, p) at x."""

    x: np.ndarray
    residual: np.ndarray
    jacobian: np.ndarray
    at_lower: np.ndarray
    at_upper: np.ndarray
    converged: bool
    iterations: int

    @property
    def cost(self) -> float:
        """Sum of squared residuals."""
        return float(self.residual @ self.residual)

    @property
    def at_bound(self) -> np.ndarray:
        """Which parameters ended on a bound."""
        return self.at_lower | self.at_upper


def solve(
    residuals: Residuals,
    start: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    scale: np.ndarray | None = None,
    tolerance: float = 1e-10,
    iterations: int = 120,
) -> Solution:
    """Minimise the sum of squares from `start` inside the bounds.

    `scale` is the size of a change that matters (default: the start values), in the parameters'
    units; `tolerance` is the relative gain in cost below which the search ends.
    """
    lower, upper = np.asarray(lower, float), np.asarray(upper, float)
    x = np.clip(np.asarray(start, float), lower, upper)
    scale = np.where(x == 0.0, 1.0, np.abs(x)) if scale is None else np.asarray(scale, float)
    damping, converged, count, small = 1e-3, False, 0, 0
    r, jac = linearise(residuals, x, lower, upper, scale)
    while count < iterations and not converged:
        count += 1
        trials = _trials(x, r, jac, damping * DAMPING, lower, upper, scale)
        kept = _different(trials, x, scale)
        best, found, ahead = _look(residuals, trials[kept], lower, upper, scale)
        best = int(kept[best])
        cost = float(r @ r)
        gain = cost - float(found @ found)
        if not gain > 0.0:
            still = damping > 1e6 or bool(np.all(np.abs(trials - x) <= 1e-9 * scale))
            converged = still or _is_stationary(x, r, jac, lower, upper, scale)
            damping *= 1e4
            continue
        damping = min(max(damping * DAMPING[best], 1e-9), 1e6)
        moved = np.max(np.abs(trials[best] - x) / scale)
        x, r = trials[best], found
        jac = linearise(residuals, x, lower, upper, scale)[1] if ahead is None else ahead
        # A small gain means the end only where the step was not held back by damping.
        small = small + 1 if gain <= tolerance * cost or moved <= 1e-7 else 0
        converged = bool(small) and (damping < 1e-2 or small > 3)
    edge = 1e-9 * np.maximum(scale, 1e-12)
    return Solution(x, r, jac, x <= lower + edge, x >= upper - edge, bool(converged), count)


def linearise(
    residuals: Residuals,
    x: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    scale: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Residual (n,) and Jacobian (n, p) by central differences that stay inside the bounds."""
    lanes, width = _stencil(x, lower, upper, scale)
    out = residuals(lanes)
    return out[0], _differences(out[1:], width)


def _stencil(
    x: np.ndarray, lower: np.ndarray, upper: np.ndarray, scale: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Lanes (1 + 2 p, p): x, then every parameter moved up, then down; and the widths (p,)."""
    reach = STEP * np.maximum(np.abs(x), scale)
    up, down = np.clip(x + reach, lower, upper), np.clip(x - reach, lower, upper)
    count = len(x)
    lanes = np.tile(x, (2 * count + 1, 1))
    np.fill_diagonal(lanes[1 : count + 1], up)
    np.fill_diagonal(lanes[count + 1 :], down)
    return lanes, up - down


def _differences(out: np.ndarray, width: np.ndarray) -> np.ndarray:
    """Jacobian (n, p) from the residuals (2 p, n) of a stencil's moved lanes."""
    count = len(width)
    # Without a width both lanes are one: their difference is zero.
    return ((out[:count] - out[count:]) / np.where(width > 0.0, width, 1.0)[:, None]).T


def _different(trials: np.ndarray, x: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Places of the boldest trial and of those that are not nearly the same."""
    away = np.linalg.norm((trials - trials[0]) / scale, axis=1)
    reach = np.linalg.norm((trials[0] - x) / scale)
    return np.flatnonzero((np.arange(len(trials)) == 0) | (away > SAME * reach))


def _look(
    residuals: Residuals,
    trials: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    scale: np.ndarray,
) -> tuple[int, np.ndarray, np.ndarray | None]:
    """Best trial, its residual, and, when it is the boldest one, the Jacobian there too.

    One call for all: near the end the boldest step is the best one; half of the calls are saved.
    """
    lanes, width = _stencil(trials[0], lower, upper, scale)
    out = residuals(np.vstack([trials, lanes[1:]]))
    count = len(trials)
    costs = np.einsum("ln,ln->l", out[:count], out[:count])
    costs = np.where(np.isfinite(costs), costs, np.inf)
    best = int(np.argmin(costs))
    best = 0 if costs[0] <= costs[best] * (1.0 + 1e-8) else best
    return best, out[best], _differences(out[count:], width) if best == 0 else None


def _trials(
    x: np.ndarray,
    r: np.ndarray,
    jac: np.ndarray,
    dampings: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    scale: np.ndarray,
) -> np.ndarray:
    """One proposal per damping value, shape (lanes, p)."""
    free = _free(x, r, jac, lower, upper)
    js = jac[:, free] * scale[free]
    gradient, hessian = js.T @ r, js.T @ js
    # Of J'J the largest entry is on the diagonal.
    diagonal = np.maximum(np.diag(hessian), 1e-12 * np.max(hessian, initial=1e-288))
    trials = np.repeat(x[None, :], len(dampings), axis=0)
    for lane, value in zip(trials, dampings, strict=True):
        step = np.linalg.lstsq(hessian + np.diag(value * diagonal), -gradient, rcond=None)[0]
        lane[free] = x[free] + step * scale[free]
    return np.clip(trials, lower, upper)


def _free(
    x: np.ndarray, r: np.ndarray, jac: np.ndarray, lower: np.ndarray, upper: np.ndarray
) -> np.ndarray:
    gradient = jac.T @ r
    held = ((x <= lower) & (gradient > 0.0)) | ((x >= upper) & (gradient < 0.0))
    return np.flatnonzero(~held & np.any(jac != 0.0, axis=0))


def _is_stationary(
    x: np.ndarray,
    r: np.ndarray,
    jac: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    scale: np.ndarray,
) -> bool:
    free = _free(x, r, jac, lower, upper)
    js = jac[:, free] * scale[free]
    size = np.linalg.norm(js, axis=0) * max(float(np.linalg.norm(r)), 1e-300)
    return bool(np.all(np.abs(js.T @ r) <= 1e-5 * np.maximum(size, 1e-300)))
