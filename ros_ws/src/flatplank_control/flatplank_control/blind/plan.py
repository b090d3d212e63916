# SPDX-License-Identifier: Apache-2.0
"""What a blind campaign measures, and the noise that lies on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

SLIPS = (-0.1, -0.05, -0.02, -0.01, 0.0, 0.01, 0.02, 0.05, 0.1)
FEW = (-0.05, -0.01, 0.0, 0.01, 0.05)
LOAD, PRESSURE, STEP = 3700.0, 2.5, 1.5


@dataclass(frozen=True)
class Setting:
    """One condition."""

    kappa: float
    fz: float = LOAD
    pressure: float = PRESSURE
    alpha_deg: float = 0.0
    gamma_deg: float = 0.0


DESIGNS: dict[str, tuple[Setting, ...]] = {
    "plain": tuple(Setting(k) for k in SLIPS),
    "small": tuple(Setting(k) for k in FEW),
    "loads": tuple(Setting(k, fz) for fz in (2400.0, 3700.0, 5000.0) for k in FEW),
    "pressures": tuple(Setting(k, LOAD, p) for p in (2.0, 2.5) for k in FEW),
    "angles": tuple(Setting(k, alpha_deg=a) for a in (-2.0, 2.0) for k in FEW),
    "cambers": tuple(
        Setting(k, gamma_deg=g) for g in (-3.0, 0.0, 3.0) for k in (-0.02, 0.0, 0.02)
    ),
}  # fmt: skip
"""conditions of a campaign; every one is measured from three wheel angles"""
STARTS = (1, 2, 3)


@dataclass(frozen=True)
class Noise:
    """Noise of the forces: white part of a sample of 0.05 s, and slow parts [N], [s]."""

    white: float = 10.0
    slow: float = 8.0
    slow_time: float = 40.0
    quick: float = 0.0
    quick_time: float = 2.0
    trend: float = 0.0
    """random slope of every run, over the whole run [N]"""


NOISES = {
    "usual": Noise(),
    "quiet": Noise(7.0, 5.0, 25.0),
    "coloured": Noise(6.0, 6.0, 15.0, 9.0, 2.0),
    "trending": Noise(8.0, 5.0, 60.0, 4.0, 5.0, 15.0),
}
RELATIVE = {"fx": 1.0, "fy": 0.8, "fz": 0.9, "mx": 0.3, "mz": 0.2}
"""noise of a channel relative to that of Fx (moments per metre)"""


@dataclass(frozen=True)
class Run:
    """One run of a campaign."""

    setting: Setting
    start: int
    index: int


def runs_of(design: str, random: np.random.Generator) -> list[Run]:
    """All runs in the order in which they are made."""
    pairs = [(s, start) for s in DESIGNS[design] for start in STARTS]
    order = random.permutation(len(pairs))
    return [Run(pairs[which][0], pairs[which][1], index) for index, which in enumerate(order)]


def noise(
    kind: Noise, samples: int, dt: float, random: np.random.Generator, size: float = 1.0
) -> np.ndarray:
    """Noise of one channel of one run [N]."""
    out = kind.white * np.sqrt(0.05 / dt) * random.standard_normal(samples)
    for level, time in ((kind.slow, kind.slow_time), (kind.quick, kind.quick_time)):
        if level > 0.0:
            out += _red(level, time, samples, dt, random)
    out += kind.trend * random.standard_normal() * (np.arange(samples) / samples - 0.5)
    return size * out


def _red(level: float, time: float, samples: int, dt: float, random) -> np.ndarray:
    keep = np.exp(-dt / time)
    push = level * np.sqrt(1.0 - keep**2) * random.standard_normal(samples)
    push[0] = level * random.standard_normal()
    return lfilter([1.0], [1.0, -keep], push)


def covariance(kind: Noise, times: np.ndarray, spacing: float) -> np.ndarray:
    """Covariance of block means of the noise `spacing` seconds long at `times` [N^2]."""
    lag = np.abs(times[:, None] - times[None, :])
    out = kind.white**2 * 0.05 / spacing * np.eye(len(times))
    out += kind.slow**2 * np.exp(-lag / kind.slow_time)
    if kind.quick > 0.0:
        out += kind.quick**2 * np.exp(-lag / kind.quick_time)
    middle = times / times[-1] - 0.5
    return out + kind.trend**2 * np.outer(middle, middle)
