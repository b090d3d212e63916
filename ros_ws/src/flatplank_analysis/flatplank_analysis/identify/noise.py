# SPDX-License-Identifier: Apache-2.0
"""Autocorrelated measurement noise: an autoregressive model, and what it does to an estimate.

Samples of a force are far from independent (their autoregressive coefficients sum to 0.97-0.99):
a standard error that counts samples is far too small. The noise is described by
e_i = sum a_k e_(i-k) + w_i and comes from differences between repeats where there are repeats.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

MAX_ORDER = 8
SPECTRAL_RADIUS = 0.999
"""Poles are drawn inside this radius, so that a short record cannot give an endless memory."""


@dataclass(frozen=True)
class ARNoise:
    """Autoregressive noise at one sample spacing."""

    coefficients: tuple[float, ...]
    """a_1, a_2, ... [-]."""
    innovation: float
    """Standard deviation of w [N]."""
    samples: int
    """Number of samples that it was fitted to."""

    @property
    def gain(self) -> float:
        """Standard deviation of a slow mean over that of independent samples."""
        return 1.0 / max(1.0 - sum(self.coefficients), 1e-3)

    @property
    def std(self) -> float:
        """Standard deviation of the noise itself [N]."""
        impulse = np.zeros(20000)
        impulse[0] = self.innovation
        return float(np.linalg.norm(self.colour(impulse)))

    @property
    def effective_samples(self) -> float:
        """Independent values that the record it was fitted to is worth."""
        if self.innovation == 0.0:
            return float(self.samples)
        return self.samples * (self.std / (self.innovation * self.gain)) ** 2

    def whiten(self, values: np.ndarray) -> np.ndarray:
        """Values along the last axis as independent ones of variance 1."""
        taps = np.concatenate([[1.0], -np.asarray(self.coefficients)])
        return lfilter(taps, [1.0], values, axis=-1) / max(self.innovation, 1e-300)

    def colour(self, white: np.ndarray) -> np.ndarray:
        """The reverse: noise with this autocorrelation from innovations (last axis)."""
        taps = np.concatenate([[1.0], -np.asarray(self.coefficients)])
        return lfilter([1.0], taps, white, axis=-1)

    def score_covariance(self, jacobian: np.ndarray) -> np.ndarray:
        """J' Omega J for a Jacobian (n, p): covariance of J'e for this noise."""
        # J' A^-1 A^-T J: the all-pole filter of each column, run backwards in time.
        filtered = self.colour(jacobian[::-1].T)
        return self.innovation**2 * filtered @ filtered.T


def fit_noise(series: Sequence[np.ndarray], order: int | None = None) -> ARNoise:
    """Fit by Burg's recursion to several series of one spacing; order by BIC.

    NaN-free series of residuals or of differences between repeats, each [N].
    """
    arrays = [np.asarray(s, float) for s in series if len(s) > 4 * MAX_ORDER]
    total = sum(len(a) for a in arrays)
    if not arrays or all(np.ptp(a) == 0.0 for a in arrays):
        rest = (
            np.concatenate([np.asarray(s, float) for s in series]) if len(series) else np.zeros(1)
        )
        return ARNoise((), float(np.sqrt(np.mean(rest**2))), max(len(rest), 1))
    coefficients, variances = _burg(arrays, MAX_ORDER if order is None else order)
    scores = [total * np.log(max(v, 1e-300)) + k * np.log(total) for k, v in enumerate(variances)]
    best = int(np.argmin(scores)) if order is None else order
    return ARNoise(_stable(coefficients[best]), float(np.sqrt(variances[best])), total)


def repeat_differences(groups: Sequence[np.ndarray]) -> list[np.ndarray]:
    """What differs between repeats: arrays (repeats, n) -> series scaled to one run's variance."""
    out: list[np.ndarray] = []
    for group in groups:
        group = np.asarray(group, float)
        if len(group) < 2:
            continue
        scale = np.sqrt(len(group) / (len(group) - 1.0))
        out.extend(scale * (group - group.mean(axis=0)))
    return out


def _burg(arrays: list[np.ndarray], order: int) -> tuple[list[np.ndarray], list[float]]:
    forward = [a.copy() for a in arrays]
    backward = [a.copy() for a in arrays]
    total = sum(len(a) for a in arrays)
    variance = sum(float(a @ a) for a in arrays) / total
    a = np.zeros(0)
    coefficients, variances = [a], [variance]
    for _ in range(order):
        top = bottom = 0.0
        for f, b in zip(forward, backward, strict=True):
            top += 2.0 * float(f[1:] @ b[:-1])
            bottom += float(f[1:] @ f[1:] + b[:-1] @ b[:-1])
        k = top / bottom if bottom > 0.0 else 0.0
        pairs = [
            (f[1:] - k * b[:-1], b[:-1] - k * f[1:])
            for f, b in zip(forward, backward, strict=True)
        ]
        forward, backward = [p[0] for p in pairs], [p[1] for p in pairs]
        a = np.concatenate([a - k * a[::-1], [k]])
        variance *= 1.0 - k * k
        coefficients.append(a)
        variances.append(variance)
    return coefficients, variances


def _stable(a: np.ndarray) -> tuple[float, ...]:
    if len(a) == 0:
        return ()
    roots = np.roots(np.concatenate([[1.0], -a]))
    size = np.abs(roots)
    roots = np.where(
        size > SPECTRAL_RADIUS, roots / np.maximum(size, 1e-12) * SPECTRAL_RADIUS, roots
    )
    return tuple(float(v) for v in -np.real(np.poly(roots))[1:])
