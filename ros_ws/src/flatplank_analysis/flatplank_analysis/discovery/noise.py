# SPDX-License-Identifier: Apache-2.0
"""Noise model from repeat differences, and whitening with it (DISCOVERY 3).

Covariance over time = filtered white part + exponentials of several time constants + a level
that differs from run to run, all weights >= 0; besides, the model's stiff directions (a gain, an
offset) get a random size in every run. Used for screening and decision only.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import cholesky, solve_triangular
from scipy.optimize import nnls

from flatplank_analysis.discovery.runs import RunSet

TIMES = (0.5, 1.5, 5.0, 15.0, 50.0)
"""[s] time constants, scaled to a run of 135 s"""
NODES = 430
"""nodes of a run that are used for decisions"""


@dataclass(frozen=True)
class ChannelNoise:
    """Noise of one channel."""

    weights: np.ndarray
    """variances: white, filtered white, exponentials, level"""
    scale: np.ndarray
    """(runs,) factor on the standard deviation"""


@dataclass
class Whitener:
    """Turns residuals and columns into ones with independent unit noise."""

    picks: np.ndarray
    """indices of the nodes that are used"""
    factors: dict[tuple[int, int], np.ndarray]
    """inverse Cholesky factors by (channel, time base)"""
    base_of: np.ndarray
    """(runs,) time base"""
    noises: list[ChannelNoise]
    roughness: np.ndarray | None = None
    """(runs, samples) factor on the noise"""

    def apply(self, values: np.ndarray, run: int, channel: int) -> np.ndarray:
        """Whiten values (..., samples) of one run and channel: (..., picks)."""
        factor = self.factors[channel, int(self.base_of[run])]
        picked = values[..., self.picks]
        if self.roughness is not None:
            picked = picked / self.roughness[run, self.picks]
        return (picked @ factor.T) / self.noises[channel].scale[run]


def fit_noise(
    runs: RunSet, contrasts: np.ndarray, residual: np.ndarray | None = None
) -> list[ChannelNoise]:
    """Noise of every channel from cleaned contrasts (channels, runs, samples).

    The residual's own roughness (shorter than 3 s of 135 s) is added: encoder steps repeat
    themselves from run to run, so that differences between repeats do not show them.
    """
    out = []
    for c, contrast in enumerate(contrasts):
        noise = _channel(runs, contrast)
        if residual is not None:
            rough = _roughness(runs, residual[c])
            noise = replace(noise, weights=noise.weights + np.maximum(rough - noise.weights, 0.0))
        out.append(noise)
    return out


def _roughness(runs: RunSet, residual: np.ndarray) -> np.ndarray:
    """Variances of the short components, from the residual minus its running mean."""
    t = runs.time.mean(axis=0)
    total = float(t[-1] - t[0])
    even = np.linspace(t[0], t[-1], 900)
    d = np.stack([np.interp(even, t, row) for row in residual])
    width = max(3, int(0.022 * len(even)) | 1)
    kernel = np.ones(width) / width
    padded = np.pad(d, ((0, 0), (width // 2, width // 2)), mode="reflect")
    rough = d - np.stack([np.convolve(row, kernel, mode="valid") for row in padded])
    lags = np.arange(8)
    cut = rough[:, width:-width]
    level = np.array([np.mean(cut[:, : cut.shape[1] - k] * cut[:, k:]) for k in lags])
    basis = _kernel(lags * (even[1] - even[0]), total)
    short = [0, 1, 2]
    weights, _ = nnls(basis[short].T, level)
    out = np.zeros(len(basis))
    out[short] = weights
    return out


def _kernel(tau: np.ndarray, total: float) -> np.ndarray:
    """Correlations at time lag tau, (components, ...)."""
    stretch = total / 135.0
    same = (tau < 1e-9).astype(float)
    near = np.exp(-((tau / (2.0 * 0.075 * stretch)) ** 2))
    slow = [np.exp(-tau / (t * stretch)) for t in TIMES]
    return np.stack([same, near, *slow, np.ones_like(tau)])


def _channel(runs: RunSet, contrast: np.ndarray) -> ChannelNoise:
    sizes = np.array([len(runs.groups[c]) for c in runs.condition])
    good = sizes > 1
    picks = np.unique(np.linspace(0, runs.samples - 1, 330).astype(int))
    d = contrast[good][:, picks] * np.sqrt(sizes[good] / (sizes[good] - 1.0))[:, None]
    t = runs.time[good][:, picks].mean(axis=0)
    total = float(t[-1] - t[0])
    product = d.T @ d / len(d)
    tau = np.abs(t[:, None] - t[None, :])
    upper = np.triu_indices(len(t))
    edges = np.concatenate([[-1.0], np.geomspace(0.02, 1.0, 22) * total])
    where = np.digitize(tau[upper], edges) - 1
    counts = np.bincount(where, minlength=len(edges)).astype(float)
    keep = counts > 0
    level = np.bincount(where, product[upper], minlength=len(edges))[keep] / counts[keep]
    basis = np.stack(
        [
            np.bincount(where, k[upper], minlength=len(edges))[keep] / counts[keep]
            for k in _kernel(tau, total)
        ]
    )
    trust = np.sqrt(np.minimum(counts[keep] / len(t), 20.0))
    # lag zero is known best; without it the total variance would be off
    trust[0] = 10.0
    weights, _ = nnls((basis * trust).T, np.maximum(level, 0.0) * trust)
    total_variance = max(float(np.mean(d**2)), 1e-12)
    if weights.sum() <= 0.0:
        weights = np.zeros(len(basis))
    weights = weights * (total_variance / max(weights.sum(), 1e-30))
    weights[0] += 0.02 * total_variance
    return ChannelNoise(weights, _run_scale(runs, contrast, sizes, total_variance))


def freedom_of(runs: RunSet, noise: ChannelNoise) -> float:
    """Independent numbers in a run by the noise model: participation ratio of its covariance."""
    t = runs.time.mean(axis=0)[:: max(1, runs.samples // 200)]
    tau = np.abs(t[:, None] - t[None, :])
    covariance = np.tensordot(noise.weights, _kernel(tau, float(t[-1] - t[0])), axes=1)
    return float(np.trace(covariance) ** 2 / max(float(np.sum(covariance**2)), 1e-30))


def _run_scale(runs: RunSet, contrast, sizes, variance: float) -> np.ndarray:
    """Noise of each condition relative to the mean, drawn towards one."""
    out = np.ones(runs.runs)
    for rows in runs.groups:
        if len(rows) < 2:
            continue
        own = float(np.sum(contrast[rows] ** 2) / ((len(rows) - 1) * runs.samples))
        freedom = 6.0 * (len(rows) - 1)
        out[rows] = np.sqrt((own * freedom + 12.0 * variance) / ((freedom + 12.0) * variance))
    return np.clip(out, 0.5, 3.0)


def make_whitener(runs: RunSet, noises: list[ChannelNoise]) -> Whitener:
    """Cholesky factors of the noise for every channel and time base."""
    step = max(1, -(-runs.samples // NODES))
    picks = np.arange(0, runs.samples, step)
    base_of, bases = _time_bases(runs)
    factors = {}
    for b, rows in enumerate(bases):
        t = runs.time[rows][:, picks].mean(axis=0)
        tau = np.abs(t[:, None] - t[None, :])
        parts = _kernel(tau, float(t[-1] - t[0]))
        for c, noise in enumerate(noises):
            covariance = np.tensordot(noise.weights, parts, axes=1)
            covariance[np.diag_indices_from(covariance)] *= 1.0 + 1e-6
            lower = cholesky(covariance, lower=True)
            inverse = solve_triangular(lower, np.eye(len(lower)), lower=True)
            factors[c, b] = inverse
    return Whitener(picks, factors, base_of, noises, runs.roughness)


def _time_bases(runs: RunSet) -> tuple[np.ndarray, list[np.ndarray]]:
    """Groups of runs whose nodes come at nearly the same times."""
    bases: list[list[int]] = []
    tolerance = 0.02 * float(np.ptp(runs.time[0]))
    for r in range(runs.runs):
        for rows in bases:
            if np.max(np.abs(runs.time[r] - runs.time[rows[0]])) < tolerance:
                rows.append(r)
                break
        else:
            bases.append([r])
    base_of = np.empty(runs.runs, dtype=int)
    for b, rows in enumerate(bases):
        base_of[rows] = b
    return base_of, [np.array(rows) for rows in bases]
