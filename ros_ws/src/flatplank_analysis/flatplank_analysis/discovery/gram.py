# SPDX-License-Identifier: Apache-2.0
"""Whitened sums of products per run: all decisions are small linear algebra on them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.noise import Whitener
from flatplank_analysis.discovery.runs import RunSet


@dataclass(frozen=True)
class Gram:
    """Per run: products of the columns, of columns and residual, of the residual."""

    products: np.ndarray
    """(runs, m, m)"""
    scores: np.ndarray
    """(runs, m)"""
    energy: np.ndarray
    """(runs,)"""

    def total(self, rows=None) -> tuple[np.ndarray, np.ndarray, float]:
        """Sums over all runs or some."""
        pick = slice(None) if rows is None else rows
        return (
            self.products[pick].sum(axis=0),
            self.scores[pick].sum(axis=0),
            float(self.energy[pick].sum()),
        )


def make_gram(
    runs: RunSet,
    whitener: Whitener,
    residual: np.ndarray,
    columns: np.ndarray,
    stiff: np.ndarray,
    scatter: np.ndarray,
    channels: tuple[int, ...] | None = None,
) -> Gram:
    """Gram of columns (m, channels, runs, samples) and the residual (channels, runs, samples).

    stiff (d, channels, runs, samples) are the directions with a random size per run of standard
    deviation scatter (d,).
    """
    m = len(columns)
    products = np.zeros((runs.runs, m, m))
    scores = np.zeros((runs.runs, m))
    energy = np.zeros(runs.runs)
    chosen = range(len(runs.channels)) if channels is None else channels
    alive = {c: np.flatnonzero(np.abs(columns[:, c]).max(axis=(1, 2)) > 0.0) for c in chosen}
    for r in range(runs.runs):
        block, ends, loose = [], [], []
        for c in chosen:
            white = np.zeros((m, len(whitener.picks)))
            if len(alive[c]):
                white[alive[c]] = whitener.apply(columns[alive[c], c, r], r, c)
            block.append(white)
            ends.append(whitener.apply(residual[c, r], r, c))
            loose.append(whitener.apply(stiff[:, c, r], r, c) * scatter[:, None])
        s = np.concatenate(block, axis=1)
        e = np.concatenate(ends)
        g = np.concatenate(loose, axis=1)
        products[r], scores[r], energy[r] = s @ s.T, s @ e, e @ e
        if len(g) and np.any(scatter > 0.0):
            inner = np.linalg.inv(np.eye(len(g)) + g @ g.T)
            sg, eg = s @ g.T, g @ e
            products[r] -= sg @ inner @ sg.T
            scores[r] -= sg @ inner @ eg
            energy[r] -= eg @ inner @ eg
    return Gram(products, scores, energy)


def scatter_of(
    runs: RunSet, whitener: Whitener, contrast: np.ndarray, stiff: np.ndarray
) -> np.ndarray:
    """Standard deviation from run to run of the stiff directions, beyond the noise (d,).

    What runs evenly with the order of the runs is no scatter but a candidate (wear, drift): left
    in, it would hide itself behind the scatter that it makes.
    """
    d = len(stiff)
    if not d:
        return np.zeros(0)
    zero = np.zeros(d)
    gram = make_gram(runs, whitener, contrast, stiff, stiff, zero)
    sizes = np.array([len(runs.groups[c]) for c in runs.condition])
    extra = np.zeros(d)
    order = np.array(runs.order, dtype=float)
    order = order - np.array([order[runs.condition == c].mean() for c in runs.condition])
    for i in range(d):
        h = gram.products[:, i, i]
        use = (sizes > 1) & (h > 1e-9)
        if not use.any():
            continue
        size = gram.scores[use, i] / h[use]
        share = 1.0 - 1.0 / sizes[use]
        # weighted method of moments, the best known runs count most
        weight = h[use]
        along = float(np.sum(weight * order[use] ** 2))
        free = float(np.sum(share))
        if along > 0.0 and free > 2.0:
            size = size - order[use] * float(np.sum(weight * size * order[use])) / along
            free -= 1.0
        seen = float(np.sum(weight * size**2))
        spread = float(np.sum(weight * share)) * free / float(np.sum(share))
        extra[i] = max((seen - free) / spread, 0.0)
    return np.sqrt(extra)


def solve(products: np.ndarray, scores: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Least-squares sizes and their covariance; directions without information get none."""
    scale = np.sqrt(np.maximum(np.diag(products), 1e-30))
    work = products / np.outer(scale, scale)
    values, vectors = np.linalg.eigh(work)
    keep = values > 1e-9 * values[-1]
    inverse = (vectors[:, keep] / values[keep]) @ vectors[:, keep].T
    inverse = inverse / np.outer(scale, scale)
    return inverse @ scores, inverse
