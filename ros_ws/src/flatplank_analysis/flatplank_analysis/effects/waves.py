# SPDX-License-Identifier: Apache-2.0
"""Waves over an angle, and the periods that a residual suggests."""

from __future__ import annotations

import numpy as np

from flatplank_analysis.discovery.runs import RunSet


def wave(angle: np.ndarray, order: int, cos: np.ndarray, sin: np.ndarray) -> np.ndarray:
    """cos * cos(order angle) + sin * sin(order angle)."""
    return cos * np.cos(order * angle) + sin * np.sin(order * angle)


def spectrum(
    runs: RunSet, residual: np.ndarray, coordinate: str, cell: float = 0.003
) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies [1/m] and coherent amplitude of the residual (runs, samples) over a place.

    All runs see the same wave at the same place: their complex amplitudes are added.
    """
    x = runs.coordinates[coordinate].values
    even = np.arange(float(x[:, 0].max()), float(x[:, -1].min()), cell)
    mean = np.mean([np.interp(even, xi, ei) for xi, ei in zip(x, residual, strict=True)], axis=0)
    window = np.hanning(len(even))
    size = 4 * len(even)
    wave_ = np.fft.rfft((mean - mean.mean()) * window, size)
    return np.fft.rfftfreq(size, cell), 2.0 * np.abs(wave_) / window.sum()


def periods(
    runs: RunSet, residual: np.ndarray, shortest: float, longest: float, count: int = 4
) -> list[float]:
    """Periods of plank travel [m] at which the residual of channel 0 waves most."""
    frequencies, level = spectrum(runs, residual[0], "plank position")
    keep = (frequencies >= 1.0 / longest) & (frequencies <= 1.0 / shortest)
    frequencies, level = frequencies[keep], level[keep]
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
