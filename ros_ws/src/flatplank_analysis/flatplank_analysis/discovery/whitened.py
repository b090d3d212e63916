# SPDX-License-Identifier: Apache-2.0
"""The whitened fit beside the plain one: decisions and sizes come from it.

The fit that is drawn, with its error, is a plain least-squares fit. Where runs
scatter, the plain fit follows those with the largest forces; the whitened one gives every run the
weight that it deserves, so its sizes are two to three times sharper. One linear step from the
plain fit finds its place only roughly: as many units of chi2 off as weak effects bring.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from flatplank_analysis.discovery.descent import Problem, descend
from flatplank_analysis.discovery.fit import Fit, Fitter, priors

ENOUGH = 0.5
"""gain of the whitened chi2 that is no evidence of anything"""


@dataclass(frozen=True)
class Whitened:
    """A fit at the smallest whitened chi2 and the chi2, what is known beforehand included."""

    fit: Fit
    chi2: float


def settle(
    metric: Callable[[np.ndarray], np.ndarray], fitter: Fitter, fit: Fit, most: int = 12
) -> Whitened:
    """Smallest whitened chi2 near a fit, with `most` Jacobians, that of the fit counted.

    metric: values (n, channels, runs, samples) in units of the noise, n rows; see `gram.Metric`.
    What is known beforehand and may not imitate an effect stays as it is.
    """
    task, loose = fitter.task(fit), fit.loose()
    begin = task.pack(fit.base, fit.terms)

    def whole(z: np.ndarray) -> np.ndarray:
        """All numbers, when those that may move are at z."""
        out = begin.copy()
        out[loose] = z
        return out

    centre, width = priors(task.entries)
    problem = Problem(
        fitter.model.runs.measured,
        lambda points: fitter.model.predict([task.lane(whole(z)) for z in points]),
        lambda z, predicted: fitter.columns(whole(z), predicted, task, loose),
        metric,
        lambda _chi2: ENOUGH,
        task.lower[loose], task.upper[loose], centre[loose], width[loose] ** -2.0,
    )  # fmt: skip
    end = descend(problem, begin[loose], fit.jacobian[loose], jacobians=most - 1)
    base, terms = task.unpack(whole(end.point.z))
    columns = fit.jacobian.copy()
    columns[loose] = end.columns
    found = replace(fit, base=base, terms=terms, predicted=end.point.predicted, jacobian=columns)
    return Whitened(found, end.point.energy)
