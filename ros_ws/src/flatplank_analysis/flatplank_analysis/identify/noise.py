# SPDX-License-Identifier: Apache-2.0
"""Autocorrelated noise and run-to-run scatter, and their part in the error of an estimate.

Samples of a force are far from independent (their autoregressive coefficients sum to 0.97-0.99),
so that a standard error from the number of samples is far too small. The noise of one run is e_i =
sum a_k e_(i-k) + w_i, determined from differences between repeats where there are repeats.

Where runs scatter, the samples of a run may be correlated in any way; only the runs' scores J_r'
e_r are used. They are corrected for the leverage of their own run (CR2 of Bell and McCaffrey), and
the degrees of freedom of the t distribution follow from the spread of information over the runs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

MAX_ORDER = 8
SPECTRAL_RADIUS = 0.999
"""Poles are moved inside this radius, so that noise of a short record has a finite variance."""


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
        """Standard deviation of a slow mean, relative to that of independent samples."""
        return 1.0 / max(1.0 - sum(self.coefficients), 1e-3)

    @property
    def std(self) -> float:
        """Standard deviation of the noise itself [N]."""
        impulse = np.zeros(20000)
        impulse[0] = self.innovation
        return float(np.linalg.norm(self.colour(impulse)))

    @property
    def effective_samples(self) -> float:
        """Number of independent values with the same information as the fitted record."""
        if self.innovation == 0.0:
            return float(self.samples)
        return self.samples * (self.std / (self.innovation * self.gain)) ** 2

    def colour(self, white: np.ndarray) -> np.ndarray:
        """Noise with this autocorrelation from innovations (last axis)."""
        taps = np.concatenate([[1.0], -np.asarray(self.coefficients)])
        return lfilter([1.0], taps, white, axis=-1)

    def score_covariance(self, jacobian: np.ndarray) -> np.ndarray:
        """J' Omega J for a Jacobian (n, p): covariance of J'e for this noise."""
        # J' A^-1 A^-T J: the all-pole filter of each column, run backwards in time.
        filtered = self.colour(jacobian[::-1].T)
        return self.innovation**2 * filtered @ filtered.T


def fit_noise(series: Sequence[np.ndarray], order: int | None = None) -> ARNoise:
    """Fit by Burg's recursion to several series of one spacing; `order` None: chosen by BIC.

    `series`: residuals, or differences between repeats, without NaN [N].
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
    """Differences between repeats (repeats, n) -> series scaled to the variance of one run."""
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


LEVERAGE_LIMIT = 0.98
"""Upper limit of a run's leverage, its share in the information on a direction: above it the fit
follows the run, and its residual does not show its scatter."""


@dataclass(frozen=True)
class Covariance:
    """Covariance (p, p) and degrees of freedom (p,) of the parameters."""

    matrix: np.ndarray
    dof: np.ndarray
    runs: np.ndarray
    """Names of the runs (runs,)."""
    run_contributions: np.ndarray
    """Contribution of every run to the error of the parameters (runs, p)."""

    @property
    def std_error(self) -> np.ndarray:
        """Standard errors (p,)."""
        return np.sqrt(np.maximum(np.diag(self.matrix), 0.0))

    @property
    def correlation(self) -> np.ndarray:
        """Correlation matrix (p, p)."""
        size = self.std_error
        scale = np.where(size > 0.0, size, 1.0)
        return self.matrix / np.outer(scale, scale)


@dataclass(frozen=True)
class PropagatedErrors:
    """Errors propagated from an earlier fit (two-step estimation, Murphy and Topel)."""

    runs: np.ndarray
    """Runs of the earlier fit (m,)."""
    response: np.ndarray
    """Change of this fit's rows by the contribution of each run to the earlier fit (m, n)."""


def run_covariance(
    jacobian: np.ndarray,
    residual: np.ndarray,
    run: np.ndarray,
    prior: np.ndarray | None = None,
    propagated: PropagatedErrors | None = None,
) -> Covariance:
    """Covariance from weighted Jacobian (n, p), residual (n,), and the run of each row (n,).

    `prior` (p, p): information that is not from runs, added to J'J. `propagated`: errors of
    parameters that were fitted before and are held here, run by run, because one run may affect
    both fits.
    """
    known = run if propagated is None else np.concatenate([run, propagated.runs])
    names, place = np.unique(known, return_inverse=True)
    index, p = place[: len(run)], jacobian.shape[1]
    scores, informations = np.zeros((len(names), p)), np.zeros((len(names), p, p))
    np.add.at(scores, index, jacobian * residual[:, None])
    np.add.at(informations, index, jacobian[:, :, None] * jacobian[:, None, :])
    own = informations.sum(axis=0)
    total = own if prior is None else own + prior
    # in coordinates where the information is the unit matrix; directions without any are left out
    values, vectors = np.linalg.eigh(total)
    kept = values > 1e-13 * max(float(values[-1]), 1e-300)
    back = vectors[:, kept] / np.sqrt(values[kept])
    whole = back.T @ informations @ back
    freed = np.array(
        [_leverage_corrected(k, back.T @ s) for k, s in zip(whole, scores, strict=True)]
    )
    if propagated is not None:
        pull = propagated.response @ jacobian @ back
        np.add.at(freed, place[len(run) :], -pull)
    matrix = freed.T @ freed
    if prior is not None:
        matrix = matrix + back.T @ prior @ back
    dof = _degrees_of_freedom(back, whole, len(names))
    return Covariance(back @ matrix @ back.T, dof, names, freed @ back.T)


def _leverage_corrected(share: np.ndarray, score: np.ndarray) -> np.ndarray:
    """(I - K_r)^(-1/2) score: corrects for the influence of the run on the fit."""
    values, vectors = np.linalg.eigh(share)
    values = np.clip(values, 0.0, LEVERAGE_LIMIT)
    return vectors @ ((vectors.T @ score) / np.sqrt(1.0 - values))


def _degrees_of_freedom(back: np.ndarray, whole: np.ndarray, runs: int) -> np.ndarray:
    """Per parameter (p,): effective number of runs that determine it, times the share of runs
    that remain after one has been taken for each parameter."""
    each = np.einsum("pk,rkl,pl->rp", back, whole, back)
    total = each.sum(axis=0)
    share = each / np.where(total > 0.0, total, 1.0)
    effective = 1.0 / np.maximum(np.sum(share**2, axis=0), 1e-12)
    left = max(runs - back.shape[1], 1) / runs
    return np.maximum(effective * left, 1.0)
