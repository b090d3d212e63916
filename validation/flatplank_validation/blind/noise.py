# SPDX-License-Identifier: Apache-2.0
"""Noise of the blind campaigns, and its covariance for the detectable sizes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

OCTAVES = (0.1, 0.4, 1.6, 6.4, 25.6, 102.4)
"""correlation times of the parts that sum to 1/f noise [s]"""
MAINS = ((50.02, 1.0), (100.04, 0.4), (150.06, 0.2))
"""mains frequencies [Hz] and relative amplitudes; sampled without a filter they alias to slow
waves"""
WARM_UP = 60.0
"""time constant of the warm-up [s]"""
SPIKE = (50.0, 150.0)
"""range of the height of spikes [N]"""
STUCK = (10, 30)
"""range of the length of stuck stretches [samples]"""


@dataclass(frozen=True)
class Noise:
    """Noise of the forces: white part per sample of 0.05 s [N], slow parts [N] and their times
    [s]."""

    white: float = 10.0
    slow: float = 8.0
    slow_time: float = 40.0
    quick: float = 0.0
    quick_time: float = 2.0
    trend: float = 0.0
    """random slope of every run, over the whole run [N]"""
    pink: float = 0.0
    """1/f noise: level of each of its parts [N]"""
    hum: float = 0.0
    """amplitude of the mains hum, with harmonics [N]"""
    warm: float = 0.0
    """random drift of every run while it warms up [N]"""
    spikes: float = 0.0
    """share of samples that are outliers [-]"""
    step: float = 0.0
    """step of the converter [N]"""
    stuck: float = 0.0
    """share of runs in which a channel is stuck for about a second [-]"""

    def parts(self) -> tuple[tuple[float, float], ...]:
        """Level [N] and correlation time [s] of the slow parts."""
        own = ((self.slow, self.slow_time), (self.quick, self.quick_time))
        return (*own, *((self.pink, time) for time in OCTAVES))


NOISES = {
    "usual": Noise(),
    "quiet": Noise(7.0, 5.0, 25.0),
    "coloured": Noise(6.0, 6.0, 15.0, 9.0, 2.0),
    "trending": Noise(8.0, 5.0, 60.0, 4.0, 5.0, 15.0),
    "faint": Noise(1.0, 0.8, 40.0),
    "loud": Noise(30.0, 24.0, 40.0),
    "measured": Noise(
        8.0, 0.0, pink=4.0, hum=3.0, warm=6.0, spikes=5e-4, step=2.0, stuck=0.1
    ),
}  # fmt: skip
"""name -> noise; the first four belong to the family of a whitener with few terms, `measured` does
not"""
RELATIVE = {"fx": 1.0, "fy": 0.8, "fz": 0.9, "mx": 0.3, "mz": 0.2}
"""noise of a channel relative to that of Fx (moments in N m per N)"""


def noise(
    kind: Noise, samples: int, dt: float, random: np.random.Generator, size: float = 1.0
) -> np.ndarray:
    """Noise of one channel of one run [N]."""
    out = kind.white * np.sqrt(0.05 / dt) * random.standard_normal(samples)
    for level, time in kind.parts():
        if level > 0.0:
            out += _red(level, time, samples, dt, random)
    at = np.arange(samples)
    out += kind.trend * random.standard_normal() * (at / samples - 0.5)
    if kind.hum > 0.0:
        for frequency, part in MAINS:
            out += kind.hum * part * np.sin(math.tau * (frequency * at * dt + random.random()))
    if kind.warm > 0.0:
        out += kind.warm * random.standard_normal() * -np.expm1(-at * dt / WARM_UP)
    if kind.spikes > 0.0:
        far = random.random(samples) < kind.spikes
        out += far * random.uniform(*SPIKE, samples) * random.choice([-1.0, 1.0], samples)
    return size * out


def shown(
    kind: Noise, values: np.ndarray, dt: float, random: np.random.Generator, size: float = 1.0
) -> np.ndarray:
    """A channel of one run as recorded: with noise, quantisation, outliers and stuck stretches."""
    out = values + noise(kind, len(values), dt, random, size)
    if kind.stuck > 0.0 and random.random() < kind.stuck:
        first, count = int(random.integers(len(out) - STUCK[1])), int(random.integers(*STUCK))
        out[first : first + count] = out[first]
    step = kind.step * size
    return np.round(out / step) * step if step > 0.0 else out


def _red(level: float, time: float, samples: int, dt: float, random) -> np.ndarray:
    keep = np.exp(-dt / time)
    push = level * np.sqrt(1.0 - keep**2) * random.standard_normal(samples)
    push[0] = level * random.standard_normal()
    return lfilter([1.0], [1.0, -keep], push)


def covariance(kind: Noise, times: np.ndarray, spacing: float) -> np.ndarray:
    """Covariance of block means of the noise `spacing` seconds long at `times` [N^2].

    Stuck stretches, which are rare, are neglected.
    """
    lag = np.abs(times[:, None] - times[None, :])
    far = (SPIKE[0] ** 2 + SPIKE[0] * SPIKE[1] + SPIKE[1] ** 2) / 3.0
    single = kind.white**2 + kind.spikes * far + kind.step**2 / 12.0
    out = single * 0.05 / spacing * np.eye(len(times))
    for level, time in kind.parts():
        if level > 0.0:
            out += level**2 * _mean_of_red(lag, time, spacing)
    for frequency, part in MAINS:
        seen = frequency - round(frequency * 0.05) / 0.05
        wave = np.cos(math.tau * seen * lag) * np.sinc(seen * spacing) ** 2
        out += 0.5 * (kind.hum * part) ** 2 * wave
    middle, warm = times / times[-1] - 0.5, kind.warm * -np.expm1(-times / WARM_UP)
    return out + kind.trend**2 * np.outer(middle, middle) + np.outer(warm, warm)


def _mean_of_red(lag: np.ndarray, time: float, spacing: float) -> np.ndarray:
    """Covariance of block means of noise with unit variance and correlation time `time`."""
    a = time / spacing
    apart = np.exp(-np.maximum(lag - spacing, 0.0) / time) - 2.0 * np.exp(-lag / time)
    apart = a * a * (apart + np.exp(-(lag + spacing) / time))
    same = 2.0 * a * (1.0 - a * -math.expm1(-1.0 / a))
    return np.where(lag < 0.5 * spacing, same, apart)
