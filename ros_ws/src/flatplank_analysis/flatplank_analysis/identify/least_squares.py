# SPDX-License-Identifier: Apache-2.0
"""Bounded least squares of a residual function: the search of `discovery.descent` in scaled
variables, with a Jacobian by central differences. Parameter sets are computed many at a time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.descent import Problem, descend

Residuals = Callable[[np.ndarray], np.ndarray]
"""Parameters (sets, p) -> weighted residuals (sets, n)."""

STEP = 1e-4
"""Relative step of the central differences: larger than the resolution of a tabulated curve."""


@dataclass(frozen=True)
class Solution:
    """End of the search: x (p,), residual (n,), Jacobian (n, p) at x."""

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
    def edges(self) -> list[str]:
        """ "lower", "upper" or nothing for every parameter."""
        pairs = zip(self.at_lower, self.at_upper, strict=True)
        return ["lower" if low else "upper" if high else "" for low, high in pairs]

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

    `scale` is the size of a relevant change (default: the start values), in the parameters'
    units; `tolerance` is the relative decrease of the cost below which the search ends.
    """
    lower, upper = np.asarray(lower, float), np.asarray(upper, float)
    x = np.clip(np.asarray(start, float), lower, upper)
    scale = np.where(x == 0.0, 1.0, np.abs(x)) if scale is None else np.asarray(scale, float)

    def predict(points: list[np.ndarray]) -> np.ndarray:
        return residuals(np.clip(np.array(points) * scale, lower, upper))[:, None, None]

    def jacobian(z: np.ndarray, _predicted: np.ndarray | None = None) -> np.ndarray:
        columns = linearise(residuals, np.clip(z * scale, lower, upper), lower, upper, scale).T
        return (columns * scale[:, None])[:, None, None]

    problem = Problem(
        measured=np.zeros(()),
        predict=predict,
        jacobian=jacobian,
        metric=lambda values: values,
        enough=lambda cost: tolerance * cost,
        lower=lower / scale,
        upper=upper / scale,
        centre=np.zeros(len(x)),
        strength=np.zeros(len(x)),
    )
    z, count, still = x / scale, 0, False
    columns = jacobian(z)
    # converged: a search that begins with the Jacobian of its start does not move
    while count < iterations and not still:
        end = descend(problem, z, columns, iterations - count, iterations)
        count, still, z = count + end.steps, np.array_equal(end.point.z, z), end.point.z
        columns = end.columns if still or end.fresh else jacobian(z)
    x, edge = np.clip(z * scale, lower, upper), 1e-9 * np.maximum(scale, 1e-12)
    return Solution(
        x,
        end.point.predicted[0, 0],
        (columns[:, 0, 0] / scale[:, None]).T,
        x <= lower + edge,
        x >= upper - edge,
        bool(still),
        count,
    )


def linearise(
    residuals: Residuals, x: np.ndarray, lower: np.ndarray, upper: np.ndarray, scale: np.ndarray
) -> np.ndarray:
    """Jacobian (n, p) by central differences that stay inside the bounds."""
    reach = STEP * np.maximum(np.abs(x), scale)
    up, down = np.clip(x + reach, lower, upper), np.clip(x - reach, lower, upper)
    count, width = len(x), up - down
    sets = np.tile(x, (2 * count, 1))
    np.fill_diagonal(sets[:count], up)
    np.fill_diagonal(sets[count:], down)
    out = residuals(sets)
    # with zero width both parameter sets are equal, and so their difference is zero
    return ((out[:count] - out[count:]) / np.where(width > 0.0, width, 1.0)[:, None]).T
