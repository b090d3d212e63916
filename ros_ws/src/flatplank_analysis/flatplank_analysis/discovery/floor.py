# SPDX-License-Identifier: Apache-2.0
"""The floor from repeats, and what of the residual is beyond it (DISCOVERY 2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.runs import RunSet


@dataclass(frozen=True)
class Floor:
    """Levels of one channel, in its unit."""

    floor: float
    """scatter between repeats, what effects that differ between repeats explain taken out"""
    raw: float
    """scatter between repeats as it is"""
    unexplained: float
    """systematic part of the residual beyond the floor"""
    per_condition: np.ndarray
    """(conditions,) the same by condition"""
    rmse_condition: np.ndarray
    """(conditions,) root mean square of the residual"""
    freedom: float
    """number of repeat contrasts behind the floor (runs, not samples)"""

    @property
    def varying(self) -> float:
        """Part that differs between repeats and is explained by what differs between them."""
        return float(np.sqrt(max(self.raw**2 - self.floor**2, 0.0)))


def contrast_columns(runs: RunSet, columns: np.ndarray, least: float = 0.15) -> np.ndarray:
    """Columns (m, runs, samples) that differ between repeats by more than a share of themselves."""
    if not len(columns):
        return columns
    contrasts = runs.contrast(columns)
    size = np.sqrt(np.mean(columns**2, axis=(1, 2)))
    varying = np.sqrt(np.mean(contrasts**2, axis=(1, 2)))
    return contrasts[varying > least * np.maximum(size, 1e-30)]


def clean_contrasts(runs: RunSet, residual: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Within-condition contrasts of a channel with the contrasts of `columns` regressed out."""
    contrast = runs.contrast(residual)
    used = contrast_columns(runs, columns)
    if not len(used):
        return contrast
    flat = used.reshape(len(used), -1)
    scale = np.sqrt(np.mean(flat**2, axis=1))
    flat = flat / scale[:, None]
    gram = flat @ flat.T
    right = flat @ contrast.reshape(-1)
    fit = np.linalg.lstsq(gram + 1e-9 * np.trace(gram) * np.eye(len(gram)), right, rcond=None)[0]
    return contrast - (fit @ flat).reshape(contrast.shape)


def floor_of(runs: RunSet, residual: np.ndarray, columns: np.ndarray) -> Floor:
    """Floor and unexplained part of one channel; residual (runs, samples)."""
    cleaned = clean_contrasts(runs, residual, columns)
    counts = np.array([len(g) for g in runs.groups])
    spare = sum((k - 1) for k in counts) * runs.samples
    pure = float(np.sum(cleaned**2) / max(spare, 1))
    raw = float(np.sum(runs.contrast(residual) ** 2) / max(spare, 1))
    mean = runs.mean(residual - cleaned_part(runs, residual, cleaned))
    beyond = np.mean(mean**2, axis=1) - pure / counts
    rms = np.sqrt([np.mean(residual[g] ** 2) for g in runs.groups])
    total = float(np.average(beyond, weights=counts))
    return Floor(
        floor=float(np.sqrt(pure)),
        raw=float(np.sqrt(raw)),
        unexplained=float(np.sqrt(max(total, 0.0))),
        per_condition=np.sqrt(np.maximum(beyond, 0.0)),
        rmse_condition=rms,
        freedom=float(np.sum(counts - 1)),
    )


def cleaned_part(runs: RunSet, residual: np.ndarray, cleaned: np.ndarray) -> np.ndarray:
    """What regression took out of the contrasts; its mean over repeats is zero."""
    return runs.contrast(residual) - cleaned
