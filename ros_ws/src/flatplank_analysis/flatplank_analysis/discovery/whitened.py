# SPDX-License-Identifier: Apache-2.0
"""The whitened fit beside the plain one: decisions and sizes come from it.

The fit that is drawn, with its error, is a plain least-squares fit (DISCOVERY 3). Where runs
scatter, the plain fit follows those with the largest forces; the whitened one gives every run the
weight that it deserves, so its sizes are two to three times sharper. One linear step from the
plain fit finds its place only roughly: as many units of chi2 off as weak effects bring.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.fit import Fit, Fitter, bounded_step, priors
from flatplank_analysis.discovery.gram import Gram

ENOUGH = 0.5
"""gain of the whitened chi2 that is no evidence of anything"""
KEPT = 0.5
"""share of the promised gain with which a step is good"""
TRIALS = (1e-7, 1e-3, 1e-2, 1e-1, 1.0, 10.0)
"""damping of the steps that are tried"""
Grams = Callable[[np.ndarray, np.ndarray], Gram]
"""whitened sums of a residual and columns"""


@dataclass(frozen=True)
class Whitened:
    """A fit at the smallest whitened chi2 and the chi2, what is known beforehand included."""

    fit: Fit
    chi2: float


def settle(grams: Grams, fitter: Fitter, fit: Fit, most: int = 12) -> Whitened:
    """Smallest whitened chi2 near a fit, by damped Gauss-Newton with `most` Jacobians.

    What is known beforehand and may not imitate an effect stays as it is.
    """
    return _Descent(grams, fitter, fit).run(fit, most)


class _Descent:
    def __init__(self, grams: Grams, fitter: Fitter, fit: Fit) -> None:
        self.grams, self.fitter = grams, fitter
        self.measured = fitter.model.runs.measured
        self.task = fitter.task(fit)
        self.loose = fit.loose()
        centre, width = priors(self.task.entries)
        self.centre, self.strength = centre[self.loose], width[self.loose] ** -2.0

    def run(self, fit: Fit, most: int) -> Whitened:
        z = self.task.pack(fit.base, fit.terms)
        chi2 = self.chi2(fit, z)
        for count in range(most):
            if count:
                fit = self.fitter.derivative(fit)
            found, promised = self.best_step(fit, z, chi2)
            if found is None:
                break
            straight = promised - (chi2 - found[0]) < ENOUGH and self.inside(found[2])
            chi2, fit, z = found
            if straight:
                break
        return Whitened(fit, chi2)

    def inside(self, z: np.ndarray) -> bool:
        """True when no number stands at an end of its range, where a step may have been cut."""
        return bool(np.all((z > self.task.lower) & (z < self.task.upper)))

    def best_step(
        self, fit: Fit, z: np.ndarray, chi2: float
    ) -> tuple[tuple[float, Fit, np.ndarray] | None, float]:
        """The best of some damped steps, None when none helps; and what the first promised."""
        assert fit.jacobian is not None
        columns = fit.jacobian[self.loose]
        products, scores, _ = self.grams(fit.residual(self.measured), columns).total()
        away = z[self.loose] - self.centre
        hessian = products + np.diag(self.strength)
        slope = scores - self.strength * away
        low = self.task.lower[self.loose] - z[self.loose]
        high = self.task.upper[self.loose] - z[self.loose]
        best, promised = None, 0.0
        for damping in TRIALS:
            move = bounded_step(hessian, slope, low, high, damping)
            expected = float(2.0 * move @ slope - move @ hessian @ move)
            promised = promised or expected
            if expected < ENOUGH:
                break
            end = z.copy()
            end[self.loose] += move
            end = np.clip(end, self.task.lower, self.task.upper)
            tried = self.fitter.at(self.task, end, fit)
            value = self.chi2(tried, end)
            if value < chi2 and (best is None or value < best[0]):
                best = value, tried, end
            if chi2 - value > KEPT * expected:
                break
        return best, promised

    def chi2(self, fit: Fit, z: np.ndarray) -> float:
        nothing = np.zeros((0, *fit.predicted.shape))
        energy = float(self.grams(fit.residual(self.measured), nothing).energy.sum())
        return energy + float(self.strength @ (z[self.loose] - self.centre) ** 2)
