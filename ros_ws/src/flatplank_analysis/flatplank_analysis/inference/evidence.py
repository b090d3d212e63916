# SPDX-License-Identifier: Apache-2.0
"""Evidence of a linear Gaussian model from sums of products per run.

The coefficients are of two kinds. *Fixed* ones are the same in all runs (parameters of the base
and of the effects). *Random* ones have a Gaussian prior and are independent between groups of runs
(an error of the law per condition, the size of an effect per run). Both are integrated out:
Laplace's method, which is exact for coefficients that no end of a range limits (D. J. C. MacKay,
Information Theory, Inference, and Learning Algorithms, 2003, chapter 27).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.descent import bounded_step
from flatplank_analysis.discovery.gram import Gram

SMALLEST = 1e-12
"""numerical: smallest number of its kind, relative to the largest one: eigenvalue of a precision,
square of a model error, information of a candidate"""


@dataclass(frozen=True)
class Fixed:
    """Coefficients that are the same in all runs: the first columns of the sums."""

    strength: np.ndarray
    """(p,) inverse variance of each prior"""
    pull: np.ndarray
    """(p,) strength times the distance of the prior's centre from the present value"""
    lower: np.ndarray
    upper: np.ndarray
    """(p,) ends of the range, relative to the present values"""
    distance: float = 0.0
    """sum of squares of the present values' distances from the centres of their priors, in units
    of the priors' standard deviations"""

    def without(self, places: Sequence[int]) -> Fixed:
        """The same without some coefficients, which are at the centres of their priors."""
        keep = np.setdiff1d(np.arange(len(self.strength)), places)
        strength, pull = self.strength[keep], self.pull[keep]
        return Fixed(strength, pull, self.lower[keep], self.upper[keep], self.distance)


@dataclass(frozen=True)
class Random:
    """Coefficients that are independent between groups of runs, with zero mean."""

    mix: np.ndarray
    """(k, columns) each random column as a combination of the columns of the sums"""
    group: np.ndarray
    """(runs,) number of the group of each run"""
    deviation: np.ndarray
    """(k,) standard deviation of each coefficient"""


@dataclass(frozen=True)
class Evidence:
    """Evidence of a model, in the parts that are told, and the posterior of its coefficients."""

    chi2: float
    """smallest sum of squares: of the noise, of the random coefficients, and of the priors"""
    volume: float
    """logarithm of the volume of the posterior over that of the priors of the random
    coefficients; the fixed ones count with their posterior volume"""
    step: np.ndarray
    """(p + random,) most probable coefficients, relative to the present values"""
    covariance: np.ndarray
    """(p + random, p + random) posterior covariance of the coefficients"""

    @property
    def log(self) -> float:
        """Logarithm of the evidence, but for the densities of the priors of the fixed
        coefficients and for a constant of the data."""
        return self.volume - 0.5 * self.chi2


def evidence(gram: Gram, fixed: Fixed, random: Sequence[Random] = ()) -> Evidence:
    """Evidence of a residual whose sums with all columns are known.

    gram: sums in units of the noise, of the fixed columns and then of any further ones, which
    occur only in the mixes of `random`.
    """
    places = _places(gram.scores.shape, len(fixed.strength), random)
    precision = np.einsum("rki,rkj->ij", places, gram.products @ places, optimize=True)
    score = np.einsum("rki,rk->i", places, gram.scores, optimize=True)
    weights = np.concatenate([np.repeat(r.deviation**-2.0, _groups(r)) for r in random] or [[]])
    prior = np.concatenate([fixed.strength, weights])
    precision[np.diag_indices_from(precision)] += prior
    count = len(fixed.strength)
    score[:count] += fixed.pull
    free = np.full(len(weights), np.inf)
    step = bounded_step(
        precision, score, np.append(fixed.lower, -free), np.append(fixed.upper, free), 0.0
    )
    chi2 = float(gram.energy.sum()) + fixed.distance
    chi2 += float(step @ precision @ step - 2.0 * step @ score)
    covariance, size = _inverse(precision)
    volume = 0.5 * (count * np.log(2.0 * np.pi) + float(np.sum(np.log(weights))) - size)
    return Evidence(chi2, volume, step, covariance)


def _inverse(precision: np.ndarray) -> tuple[np.ndarray, float]:
    """Inverse and logarithm of the determinant of a matrix that is positive but for rounding."""
    scale = np.sqrt(np.diag(precision))
    values, vectors = np.linalg.eigh(precision / np.outer(scale, scale))
    values = np.maximum(values, SMALLEST * values[-1])
    inverse = (vectors / values) @ vectors.T / np.outer(scale, scale)
    return inverse, float(np.sum(np.log(values)) + 2.0 * np.sum(np.log(scale)))


def _groups(random: Random) -> int:
    return int(random.group.max()) + 1


def _places(shape: tuple[int, int], fixed: int, random: Sequence[Random]) -> np.ndarray:
    """(runs, columns, coefficients): coefficients of the columns of each run."""
    runs, columns = shape
    out = [np.broadcast_to(np.eye(columns, fixed), (runs, columns, fixed))]
    for r in random:
        own = np.eye(_groups(r))[r.group]
        part = np.einsum("kc,rg->rckg", r.mix, own)
        out.append(part.reshape(runs, columns, -1))
    return np.concatenate(out, axis=2)
