# SPDX-License-Identifier: Apache-2.0
"""Scatter of the tire from run to run along given directions: a gain, a slip offset.

The amounts of a run are Gaussian with a standard deviation per direction, which the differences
among repeats show beside the noise: restricted maximum likelihood (H. D. Patterson and
R. Thompson, Biometrika 58, 1971), so that runs count by what noise and scatter leave of their
information.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import minimize

from flatplank_analysis.discovery.gram import Gram, Metric
from flatplank_analysis.discovery.noise import Whitener
from flatplank_analysis.discovery.runs import RunSet

LEAST = 1e-3
"""numerical: scatter, in standard errors of the mean amount of all runs, that is none"""


def scatter_of(
    runs: RunSet, whitener: Whitener, contrast: np.ndarray, directions: np.ndarray,
    assumed: Sequence[float] = (),
) -> np.ndarray:  # fmt: skip
    """Standard deviation from run to run along the directions of the scatter, beyond the noise
    (d,).

    assumed: values where no repeat shows them; without these there is no scatter.
    A linear trend over the order of the runs is removed: it is a candidate effect (wear, drift),
    which would otherwise hide behind the scatter that it causes itself.
    """
    d = len(directions)
    if not d:
        return np.zeros(0)
    if not runs.repeated:
        return np.array(assumed if len(assumed) == d else np.zeros(d), dtype=float)
    gram = Metric(whitener, directions, np.zeros(d)).gram(contrast, directions)
    size = np.array([len(runs.groups[c]) for c in runs.condition])
    order = np.array(runs.order, dtype=float)
    order -= np.array([order[runs.condition == c].mean() for c in runs.condition])
    return likeliest_deviations(gram, 1.0 - 1.0 / size, order)


def likeliest_deviations(gram: Gram, share: np.ndarray, order: np.ndarray) -> np.ndarray:
    """Likeliest standard deviations (d,) of the amounts of the columns.

    share (runs,): part of a run that the mean of its condition leaves; order (runs,): its place
    among the runs, relative to the mean of its condition.
    """
    information = np.einsum("r,rii->i", share, gram.products)
    out = np.zeros(len(information))
    seen = np.flatnonzero(information > 0.0)
    if not seen.size:
        return out
    # in units of the standard error of the mean amount of all runs
    unit = 1.0 / np.sqrt(information[seen])
    products = gram.products[:, seen][:, :, seen] * np.outer(unit, unit)
    scores = gram.scores[:, seen] * unit
    alone = np.einsum("rii->ri", products)
    square = np.sum(scores**2, axis=0) / np.sum(share[:, None] * alone**2, axis=0)
    start = np.sqrt(np.maximum(square, 1.0))
    found = minimize(
        _loss, np.log(start), args=(products, scores, share, order), method="L-BFGS-B",
        bounds=[(np.log(LEAST), None)] * len(seen),
    )  # fmt: skip
    sizes = np.exp(found.x)
    out[seen] = np.where(sizes > 2.0 * LEAST, sizes * unit, 0.0)
    return out


def _loss(
    logs: np.ndarray, products: np.ndarray, scores: np.ndarray, share: np.ndarray,
    order: np.ndarray,
) -> float:  # fmt: skip
    """Minus twice the logarithm of the restricted likelihood of standard deviations, but for a
    constant."""
    variance = np.exp(2.0 * logs)
    inner = products + np.diag(1.0 / variance)
    left = np.linalg.solve(inner, np.concatenate([products, scores[:, :, None]], axis=2))
    spread = np.linalg.slogdet(inner)[1] + float(np.sum(2.0 * logs))
    loss = float(share @ spread) - float(np.sum(scores * left[:, :, -1]))
    if np.any(order):
        # scores and information of the amounts beside noise and scatter
        score = scores - np.einsum("rij,rj->ri", products, left[:, :, -1])
        information = products - products @ left[:, :, :-1]
        trend, along = order @ score, np.einsum("r,rij->ij", order**2, information)
        loss -= float(trend @ np.linalg.solve(along, trend))
        loss += float(np.linalg.slogdet(along)[1])
    return loss


def likeliest_scatter(
    whitener: Whitener, residual: np.ndarray, directions: np.ndarray, scatter: np.ndarray
) -> np.ndarray:
    """Part of a residual (channels, runs, samples) that the scatter explains best: each run's most
    probable amounts of the directions (d, channels, runs, samples), with standard deviations
    scatter (d,)."""
    used = np.flatnonzero(scatter > 0.0)
    if not used.size:
        return np.zeros_like(residual)
    gram = Metric(whitener, directions, np.zeros(len(directions))).gram(residual, directions[used])
    precision = gram.products + np.diag(1.0 / scatter[used] ** 2)
    amounts = np.linalg.solve(precision, gram.scores[..., None])[..., 0]
    return np.einsum("rd,dcrs->crs", amounts, directions[used])
