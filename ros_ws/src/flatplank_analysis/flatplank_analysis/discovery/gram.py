# SPDX-License-Identifier: Apache-2.0
"""Sums of products per run in units of the noise; all decisions are linear algebra on them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from copy import copy
from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.noise import Whitener

AT_ONCE = 200
"""runs whose columns are in memory at once, in units of the noise: about 2 MB each"""


@dataclass(frozen=True)
class Gram:
    """Per run: products of the columns, of columns and residual, and of the residual."""

    products: np.ndarray
    """(runs, m, m)"""
    scores: np.ndarray
    """(runs, m)"""
    energy: np.ndarray
    """(runs,)"""

    @classmethod
    def of(cls, s: np.ndarray, e: np.ndarray) -> Gram:
        """Sums of columns (runs, m, n) and a residual (runs, n), both already in the metric."""
        return cls(
            s @ np.swapaxes(s, 1, 2), (s @ e[:, :, None])[:, :, 0], np.einsum("ri,ri->r", e, e)
        )

    def with_priors(self, strength: np.ndarray, pull: np.ndarray) -> Gram:
        """The same sums with one more run: the priors of the first columns, which limit what
        these columns can imitate.

        strength (k,): inverse variance of each prior; pull (k,): its score at the present values.
        """
        m, k = self.scores.shape[1], len(strength)
        products, scores = np.zeros((1, m, m)), np.zeros((1, m))
        products[0, range(k), range(k)], scores[0, :k] = strength, pull
        return Gram(
            np.concatenate([self.products, products]),
            np.concatenate([self.scores, scores]),
            np.append(self.energy, 0.0),
        )

    def total(
        self, rows: Sequence[int] | np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray, float]:
        """Sums over all runs, or over those of `rows`."""
        pick = slice(None) if rows is None else rows
        return (
            self.products[pick].sum(axis=0),
            self.scores[pick].sum(axis=0),
            float(self.energy[pick].sum()),
        )


class Metric:
    """Metric of the decisions: squares of transformed residuals and columns are summed.

    Noise becomes independent and of unit size. The directions in which the tire scatters have
    a random size in every run and are down-weighted accordingly.
    """

    def __init__(self, whitener: Whitener, directions: np.ndarray, scatter: np.ndarray) -> None:
        """directions (d, channels, runs, samples) of the scatter, with standard deviations
        scatter (d,)."""
        self.whitener, self.scatter = whitener, scatter
        self._sideways: np.ndarray | None = None
        self.volume = 0.0
        """logarithm of the volume that the scatter takes from the data"""
        if np.any(scatter > 0.0):
            loose = np.moveaxis(self.white(directions), 0, 1) * scatter[:, None]
            values, vectors = np.linalg.eigh(loose @ np.swapaxes(loose, 1, 2))
            values = np.maximum(values, 1e-30)
            # with G = loose, Q = vectors, s = share: the square root of 1 - G'(1 + GG')^-1 G is
            # 1 - G'Q s Q'G
            share = (1.0 - 1.0 / np.sqrt(1.0 + values)) / values
            self._sideways = np.swapaxes(vectors, 1, 2) @ loose * np.sqrt(share)[:, :, None]
            self.volume = -0.5 * float(np.sum(np.log1p(values)))

    def __call__(self, values: np.ndarray) -> np.ndarray:
        """Values (n, channels, runs, samples) in units of the noise: (n, runs, m)."""
        return self.beside_scatter(self.white(values))

    def along(self, directions: np.ndarray) -> Metric:
        """The same noise and scatter, along the directions that the tire has at another fit."""
        return Metric(self.whitener, directions, self.scatter)

    def beside_scatter(self, white: np.ndarray) -> np.ndarray:
        """Values (n, runs, m) in units of the noise with the scatter down-weighted, in place."""
        if self._sideways is not None:
            for r, side in enumerate(self._sideways):
                white[:, r] -= (white[:, r] @ side.T) @ side
        return white

    def gram(self, residual: np.ndarray, *columns: np.ndarray) -> Gram:
        """Sums of a residual (channels, runs, samples) and blocks of columns (n, ... the same)."""
        parts = []
        for rows, metric in self.by_runs(residual.shape[1]):
            white = metric(np.concatenate([block[:, :, rows] for block in columns]))
            parts.append(Gram.of(np.moveaxis(white, 0, 1), metric(residual[None, :, rows])[0]))
        if len(parts) == 1:
            return parts[0]
        return Gram(
            np.concatenate([part.products for part in parts]),
            np.concatenate([part.scores for part in parts]),
            np.concatenate([part.energy for part in parts]),
        )

    def by_runs(self, runs: int) -> Iterator[tuple[slice, Metric]]:
        """The metric of some runs after the other: `gram` has the columns of so many in memory."""
        for start in range(0, runs, AT_ONCE):
            rows = slice(start, start + AT_ONCE)
            part = copy(self)
            part.whitener = self.whitener.of_runs(rows)
            part._sideways = None if self._sideways is None else self._sideways[rows]
            yield rows, part

    def white(self, values: np.ndarray) -> np.ndarray:
        """Values (n, channels, runs, samples) in units of the noise alone: (n, runs, m)."""
        count, channels, runs, _ = values.shape
        out = np.zeros((count, runs, channels, len(self.whitener.picks)))
        for c in range(channels):
            alive = np.flatnonzero(np.abs(values[:, c]).max(axis=(1, 2)) > 0.0)
            if len(alive):
                out[alive, :, c] = self.whitener.apply(values[alive, c], c)
        return out.reshape(count, runs, -1)


def solve(products: np.ndarray, scores: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Least-squares solution and its covariance; directions without information stay zero."""
    scale = np.sqrt(np.maximum(np.diag(products), 1e-30))
    work = products / np.outer(scale, scale)
    values, vectors = np.linalg.eigh(work)
    keep = values > 1e-9 * values[-1]
    inverse = (vectors[:, keep] / values[keep]) @ vectors[:, keep].T
    inverse = inverse / np.outer(scale, scale)
    return inverse @ scores, inverse
