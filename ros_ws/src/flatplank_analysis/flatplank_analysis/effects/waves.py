# SPDX-License-Identifier: Apache-2.0
"""Waves over an angle, and the periods that a residual suggests."""

from __future__ import annotations

import numpy as np

from flatplank_analysis.discovery.runs import RunSet


def wave(angle: np.ndarray, order: int, cos: np.ndarray, sin: np.ndarray) -> np.ndarray:
    """cos * cos(order angle) + sin * sin(order angle)."""
    return cos * np.cos(order * angle) + sin * np.sin(order * angle)


def spectrum(
    runs: RunSet, residual: np.ndarray, frequencies: np.ndarray, coordinate: str
) -> np.ndarray:
    """Coherent amplitude of the residual (runs, samples) at each frequency of a coordinate.

    All runs see the same wave at the same place: their complex amplitudes are added.
    """
    x = runs.coordinates[coordinate].values
    weight = np.gradient(x, axis=1)
    rest = residual - residual.mean(axis=1, keepdims=True)
    weight = weight * np.hanning(x.shape[1])
    out = np.zeros(len(frequencies), dtype=complex)
    for xi, ei, wi in zip(x, rest, weight, strict=True):
        out += np.exp(-2j * np.pi * np.outer(frequencies, xi)) @ (ei * wi) / wi.sum()
    return 2.0 * np.abs(out) / len(x)


def periods(
    runs: RunSet, residual: np.ndarray, shortest: float, longest: float, count: int = 4
) -> list[float]:
    """Periods of plank travel [m] at which the residual of channel 0 waves most."""
    x = runs.coordinates["plank position"].values
    length = float(np.ptp(x[0]))
    frequencies = np.arange(1.0 / longest, 1.0 / shortest, 0.3 / length)
    # nodes lie 6 mm apart at most; thinning keeps the scan quick
    rows = np.arange(0, len(x), max(1, len(x) // 27))
    part = runs if len(rows) == len(x) else runs.subset(rows)
    level = spectrum(part, residual[0][rows], frequencies, "plank position")
    # judged against the neighbourhood, for the residual is red
    width = 12
    padded = np.pad(level, width, mode="reflect")
    around = np.array([np.median(padded[i : i + 2 * width + 1]) for i in range(len(level))])
    ratio = level / np.maximum(around, 1e-12)
    found: list[float] = []
    taken = np.zeros(len(level), dtype=bool)
    for i in np.argsort(-ratio):
        if not taken[i]:
            found.append(float(1.0 / frequencies[i]))
            taken[max(0, i - 6) : i + 7] = True
        if len(found) == count:
            break
    return found
