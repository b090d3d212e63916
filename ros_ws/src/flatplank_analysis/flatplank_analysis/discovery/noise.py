# SPDX-License-Identifier: Apache-2.0
"""Noise model from repeat differences, and whitening with it.

Covariance over time = white and filtered white part + exponentials of several time constants + a
level and a linear drift that differ from run to run, all weights >= 0. In addition the directions
in which the tire scatters (a gain, an offset) get a random size in every run. Used for screening
and decisions only.
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
"""largest number of nodes per run that decisions use"""
LEVEL = 2 + len(TIMES)
"""index of the level among the noise components"""
SLOW = 2
"""index of the first noise component that is not sensor noise"""
HIDDEN = 1e-6
"""share of a component outside the directions of the scatter below which it gets no weight"""


@dataclass(frozen=True)
class ChannelNoise:
    """Noise of one channel."""

    weights: np.ndarray
    """variances, in the mean over a run: white, filtered white, exponentials, level, drift"""
    scale: np.ndarray
    """(runs,) factor on the standard deviation"""


@dataclass
class Whitener:
    """Transforms residuals and columns so that their noise is independent and of unit size."""

    picks: np.ndarray
    """indices of the nodes that are used"""
    factors: dict[tuple[int, int], np.ndarray]
    """inverse Cholesky factors by (channel, time base)"""
    base_of: np.ndarray
    """(runs,) time base: runs with the same times and roughness of the nodes"""
    noises: list[ChannelNoise]

    def of_runs(self, rows: slice) -> Whitener:
        """The same for some of the runs."""
        noises = [replace(noise, scale=noise.scale[rows]) for noise in self.noises]
        return Whitener(self.picks, self.factors, self.base_of[rows], noises)

    def apply(self, values: np.ndarray, channel: int) -> np.ndarray:
        """Whiten values (n, runs, samples) of one channel: (n, runs, picks)."""
        picked = values[..., self.picks]
        out = np.empty(picked.shape)
        for base in np.unique(self.base_of):
            rows = self.base_of == base
            flat = picked[:, rows].reshape(-1, len(self.picks))
            white = flat @ self.factors[channel, int(base)].T
            out[:, rows] = white.reshape(len(values), -1, len(self.picks))
        return out / self.noises[channel].scale[:, None]


def fit_noise(
    runs: RunSet, contrasts: np.ndarray, residual: np.ndarray, directions: np.ndarray
) -> list[ChannelNoise]:
    """Noise of every channel from cleaned contrasts (channels, runs, samples).

    The `directions` (d, channels, runs, samples) in which the tire scatters are projected out of
    each contrast first: this scatter is modelled separately; counted as noise, too, it would hide
    all slow effects. The short-term part of the residual (below 3 s of 135 s) is added: encoder
    steps are the same in all repeats, so that differences between repeats do not show them.
    """
    out = []
    for c, contrast in enumerate(contrasts):
        noise = _channel(runs, contrast, directions[:, c])
        rough = _roughness(runs, residual[c])
        out.append(replace(noise, weights=noise.weights + np.maximum(rough - noise.weights, 0.0)))
    return out


def no_quieter(noise: ChannelNoise, level: float) -> ChannelNoise:
    """The same noise, with larger slow components where its total is below `level`."""
    lacking = (level / float(np.median(noise.scale))) ** 2 - float(noise.weights.sum())
    if lacking <= 0.0:
        return noise
    weights = noise.weights.copy()
    weights[SLOW:] += lacking / len(weights[SLOW:])
    return replace(noise, weights=weights)


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
    out = np.zeros(len(basis) + 1)
    out[short] = weights
    return out


def _kernel(tau: np.ndarray, total: float) -> np.ndarray:
    """Correlations at time lag tau of the components but the drift, (components, ...)."""
    stretch = total / 135.0
    same = (tau < 1e-9).astype(float)
    near = np.exp(-((tau / (2.0 * 0.075 * stretch)) ** 2))
    slow = [np.exp(-tau / (t * stretch)) for t in TIMES]
    return np.stack([same, near, *slow, np.ones_like(tau)])


def _components(t: np.ndarray) -> np.ndarray:
    """Correlations of all components between times (n,), shape (components, n, n)."""
    total = float(t[-1] - t[0])
    drift = np.sqrt(12.0) * (t - t.mean()) / total
    stationary = _kernel(np.abs(t[:, None] - t), total)
    return np.concatenate([stationary, np.outer(drift, drift)[None]])


def _channel(runs: RunSet, contrast: np.ndarray, directions: np.ndarray) -> ChannelNoise:
    picks = np.unique(np.linspace(0, runs.samples - 1, 330).astype(int))
    # without repeats the residual is taken as noise, each run separately
    groups = [g for g in runs.groups if len(g) > 1] or [np.array([r]) for r in range(runs.runs)]
    spare = np.array([max(len(g) - 1.0, 1.0) for g in groups])
    rows = np.concatenate(groups)
    t = runs.time[rows][:, picks].mean(axis=0)
    tau = np.abs(t[:, None] - t[None, :])
    kernels = _components(t)
    product, expected = np.zeros_like(tau), np.zeros_like(kernels)
    energy, traces = [], []
    for g, own in zip(groups, spare, strict=True):
        q = _orthonormal(directions[:, g][:, :, picks].mean(axis=1))
        d = contrast[g][:, picks]
        d = d - (d @ q) @ q.T
        part = _without(kernels, q)
        product += d.T @ d / spare.sum()
        expected += part * (own / spare.sum())
        energy.append(float(np.sum(d**2)))
        traces.append(np.trace(part, axis1=1, axis2=2))
    weights = _weights(product, expected, tau)
    # the directions hide most of a level: what they leave determines it badly, but it is no larger
    # than all that the repeats show
    shown = float(np.sum(contrast[rows] ** 2)) / (spare.sum() * runs.samples)
    excess = max(float(weights.sum()) - shown, 0.0)
    weights[LEVEL] = max(weights[LEVEL] - excess, 0.0)
    usual = np.array([float(weights @ trace) for trace in traces])
    scale = np.ones(runs.runs)
    for g, total, k, normal in zip(groups, energy, spare, usual, strict=True):
        scale[g] = _drawn(total / k, normal, k)
    return ChannelNoise(weights, scale)


def _orthonormal(rows: np.ndarray) -> np.ndarray:
    """Orthonormal columns (samples, k <= d) that span the rows (d, samples)."""
    u, s, _ = np.linalg.svd(rows.T, full_matrices=False)
    return u[:, s > 1e-6 * max(float(s.max(initial=0.0)), 1e-12)]


def _without(kernels: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Covariances (components, n, n) with the columns of q projected out."""
    right = kernels @ q
    inner = q.T @ right
    cross = q @ np.swapaxes(right, 1, 2)
    return kernels - cross - np.swapaxes(cross, 1, 2) + q @ inner @ q.T


def _weights(product: np.ndarray, expected: np.ndarray, tau: np.ndarray) -> np.ndarray:
    """Variances of the components: non-negative least squares over the lags."""
    upper = np.triu_indices(len(tau))
    edges = np.concatenate([[-1.0], np.geomspace(0.02, 1.0, 22) * tau.max()])
    where = np.digitize(tau[upper], edges) - 1
    counts = np.bincount(where, minlength=len(edges)).astype(float)
    keep = counts > 0

    def by_lag(values: np.ndarray) -> np.ndarray:
        return np.bincount(where, values[upper], minlength=len(edges))[keep] / counts[keep]

    basis = np.stack([by_lag(k) for k in expected])
    trust = np.sqrt(np.minimum(counts[keep] / len(tau), 20.0))
    # lag zero is the most accurate; without its weight the total variance would be wrong
    trust[0] = 10.0
    total = max(float(np.trace(product)), 1e-12 * len(tau))
    shown = np.trace(expected, axis1=1, axis2=2)
    seen = shown > HIDDEN * len(tau)
    weights = np.zeros(len(expected))
    weights[seen], _ = nnls((basis[seen] * trust).T, by_lag(product) * trust)
    if float(weights @ shown) <= 0.0:
        weights = np.zeros(len(expected))
    else:
        weights = weights * (total / float(weights @ shown))
    weights[0] += 0.02 * total / len(tau)
    return weights


def _drawn(own: float, usual: float, spare: float) -> float:
    """Noise of a condition relative to the average, shrunk towards one."""
    freedom = 6.0 * spare
    ratio = (own / max(usual, 1e-30) * freedom + 12.0) / (freedom + 12.0)
    return float(np.clip(np.sqrt(ratio), 0.5, 3.0))


def freedom_of(runs: RunSet, noise: ChannelNoise) -> float:
    """Independent numbers in a run by the noise model: participation ratio of its covariance."""
    t = runs.time.mean(axis=0)[:: max(1, runs.samples // 200)]
    covariance = np.tensordot(noise.weights, _components(t), axes=1)
    return float(np.trace(covariance) ** 2 / max(float(np.sum(covariance**2)), 1e-30))


def make_whitener(runs: RunSet, noises: list[ChannelNoise]) -> Whitener:
    """Cholesky factors of the noise for every channel and time base.

    Where the model is inaccurate (`RunSet.roughness`), its error has the covariance of the noise,
    but is independent of it: the level of a run is as well known there as elsewhere.
    """
    step = max(1, -(-runs.samples // NODES))
    picks = np.arange(0, runs.samples, step)
    rough = np.ones_like(runs.time) if runs.roughness is None else runs.roughness
    extra = np.sqrt(rough**2 - 1.0)[:, picks]
    base_of, bases = _time_bases(runs, extra)
    factors = {}
    for b, rows in enumerate(bases):
        t = runs.time[rows][:, picks].mean(axis=0)
        parts = _components(t)
        more = 1.0 + np.outer(extra[rows[0]], extra[rows[0]])
        for c, noise in enumerate(noises):
            covariance = np.tensordot(noise.weights, parts, axes=1) * more
            covariance[np.diag_indices_from(covariance)] *= 1.0 + 1e-6
            lower = cholesky(covariance, lower=True)
            inverse = solve_triangular(lower, np.eye(len(lower)), lower=True)
            factors[c, b] = inverse
    return Whitener(picks, factors, base_of, noises)


def _time_bases(runs: RunSet, extra: np.ndarray) -> tuple[np.ndarray, list[np.ndarray]]:
    """Groups of runs whose nodes come at nearly the same times, with the same roughness."""
    bases: list[list[int]] = []
    tolerance = 0.02 * float(np.ptp(runs.time[0]))
    for r in range(runs.runs):
        for rows in bases:
            near = np.max(np.abs(runs.time[r] - runs.time[rows[0]])) < tolerance
            if near and np.array_equal(extra[r], extra[rows[0]]):
                rows.append(r)
                break
        else:
            bases.append([r])
    base_of = np.empty(runs.runs, dtype=int)
    for b, rows in enumerate(bases):
        base_of[rows] = b
    return base_of, [np.array(rows) for rows in bases]
