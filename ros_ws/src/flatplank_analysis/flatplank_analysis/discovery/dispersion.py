# SPDX-License-Identifier: Apache-2.0
"""Scatter of an effect's scores between runs, relative to the noise model.

An effect that shows in few runs has few scores from which to estimate its dispersion. The
dispersions of all candidates together have a typical value and spread, towards which each single
one is shrunk (moderated variances, Smyth 2004, Statistical Applications in Genetics and Molecular
Biology 3).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import digamma, polygamma

from flatplank_analysis.discovery.gram import Gram, solve

LEAST_FREEDOM, MOST_FREEDOM = 2.0, 16.0
"""limits of the degrees of freedom of the typical dispersion"""


@dataclass(frozen=True)
class TypicalDispersion:
    """Typical dispersion of a campaign, and its weight in degrees of freedom."""

    dispersion: float = 1.0
    freedom: float = LEAST_FREEDOM

    def shrink(self, kappa: float, freedom: float) -> tuple[float, float]:
        """Shrink a dispersion `kappa` towards the typical one; at least 1, with its freedom."""
        total = freedom + self.freedom
        drawn = (freedom * kappa + self.freedom * self.dispersion) / total
        return max(drawn, 1.0), total


def typical_dispersion(kappas: Sequence[float], freedoms: Sequence[float]) -> TypicalDispersion:
    """Typical dispersion and its freedom, from the moments of the logarithms."""
    pairs = [(k, f) for k, f in zip(kappas, freedoms, strict=True) if k > 0.0 and f >= 1.0]
    if len(pairs) < 5:
        return TypicalDispersion()
    k, f = np.array(pairs).T
    level = np.log(k) - digamma(f / 2.0) + np.log(f / 2.0)
    spread = float(np.var(level, ddof=1) - np.mean(polygamma(1, f / 2.0)))
    freedom = MOST_FREEDOM
    if spread > 0.0:
        freedom = float(np.clip(2.0 * _trigamma_inverse(spread), LEAST_FREEDOM, MOST_FREEDOM))
    mean = float(np.mean(level)) + float(digamma(freedom / 2.0)) - float(np.log(freedom / 2.0))
    return TypicalDispersion(max(float(np.exp(mean)), 1.0), freedom)


def _trigamma_inverse(value: float) -> float:
    """x with trigamma(x) = value, by Newton's method on 1/trigamma."""
    x = 0.5 + 1.0 / value
    for _ in range(50):
        t = float(polygamma(1, x))
        step = t * (1.0 - t / value) / float(polygamma(2, x))
        x += step
        if abs(step) < 1e-8 * x:
            break
    return x


def scores_of(gram: Gram, base: int) -> tuple[np.ndarray, np.ndarray]:
    """Score and information of the effect per run (runs,), with the base projected out."""
    products, scores, _ = gram.total()
    inverse = solve(products[:base, :base], scores[:base])[1]
    mix = inverse @ products[:base, base]
    shift = inverse @ scores[:base]
    c = gram.products
    score = gram.scores[:, base] - gram.scores[:, :base] @ mix
    score = score - (c[:, base, :base] - np.einsum("i,rij->rj", mix, c[:, :base, :base])) @ shift
    info = (
        c[:, base, base]
        - 2.0 * c[:, base, :base] @ mix
        + np.einsum("i,rij,j->r", mix, c[:, :base, :base], mix)
    )
    total = max(float(info.sum()), 1e-30)
    return score - info * float(score.sum()) / total, np.maximum(info, 0.0)


def among_repeats(
    groups: Sequence[np.ndarray], score: np.ndarray, info: np.ndarray
) -> tuple[float, float]:
    """Scatter of the scores among repeats over its expectation, and its degrees of freedom."""
    top = bottom = squares = 0.0
    for rows in groups:
        k = len(rows)
        if k < 2:
            continue
        expected = float(info[rows].sum()) * (k - 1) / k
        share = info[rows] / max(float(info[rows].sum()), 1e-30)
        spread = score[rows] - share * float(score[rows].sum())
        top += float(np.sum(spread**2))
        bottom += expected
        squares += expected**2 / (k - 1)
    if bottom <= 1e-30:
        return 1.0, 1.0
    return top / bottom, max(bottom**2 / max(squares, 1e-30), 1.0)
