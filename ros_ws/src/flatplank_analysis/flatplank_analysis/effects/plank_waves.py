# SPDX-License-Identifier: Apache-2.0
"""Waves over the plank position, and periods suggested by a residual."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.contact_patch.grid import FILTER, SPEED
from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.effects.base import Motion, Tire, Wave

SHORTEST = 80.0
"""[1/m] highest wave number: the teeth of the bench have 64, the nodes of a run resolve 83"""


def spectrum(
    runs: RunSet, residual: np.ndarray, coordinate: str, cell: float = 0.003
) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies [1/m] and coherent amplitude of the residual (runs, samples) over a place.

    All runs have the same wave at the same place: their complex amplitudes are added."""
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
    """Periods of plank travel [m] with the largest waves in the residual of channel 0."""
    frequencies, level = spectrum(runs, residual[0], "plank position")
    keep = (frequencies >= 1.0 / longest) & (frequencies <= 1.0 / shortest)
    frequencies, level = frequencies[keep], level[keep]
    # relative to the neighbourhood, because the residual has a red spectrum
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


@dataclass(frozen=True)
class LoadUndulation(Wave):
    """The plank is not level: the load on the tire varies with the plank position."""

    identifier = "load_undulation"
    title = "Load undulation over the plank that the hub does not see"
    coordinate = "plank position"
    source = "thesis 6.3, figure 6.6: support bearings and plank undulation"
    what = "Bearings and bending of the plank change the load at fixed plank positions."
    check = "Dial gauge along the plank."
    shown_by = "A reversed run: the places stay."
    removes = "Level the plank; measure the load at the contact."

    cos: float = param(
        0.0, unit="1", bounds=(-0.2, 0.2), screen=0.02, matters=0.005,
        title="cosine part", symbol="a_c",
        note="Cosine part over the plank position of the relative wave of the load.",
    )  # fmt: skip
    sin: float = param(
        0.0, unit="1", bounds=(-0.2, 0.2), screen=0.02, matters=0.005,
        title="sine part", symbol="a_s",
        note="Sine part over the plank position of the relative wave of the load.",
    )  # fmt: skip
    period: float = param(
        0.5, unit="m", bounds=(0.08, 2.5),
        title="period", symbol="λ", note="Plank travel of one wave.",
    )  # fmt: skip

    @classmethod
    def variants(cls, runs: RunSet, residual: np.ndarray) -> list[dict[str, float]]:
        # the change of the force is a share of it: of the other sign in braking than in driving
        force = runs.measured[0].mean(axis=-1, keepdims=True)
        found = periods(runs, residual * force, 0.08, 2.5)
        return [{"period": p} for p in [*found, 0.35, 0.7, 1.4]]

    @classmethod
    def scanned(cls, runs: RunSet) -> int:
        return 100

    def tire(self, tire: Tire) -> None:
        phase = 2.0 * np.pi * tire.data.position / self.period
        tire.load *= 1.0 + self.cos * np.cos(phase) + self.sin * np.sin(phase)


@dataclass(frozen=True)
class MeshRipple(Wave):
    """The plank position varies with the period of a tooth or a pinion turn, which the encoder
    on the pinion does not measure."""

    identifier = "mesh_ripple"
    title = "Speed ripple of rack and pinion"
    coordinate = "plank position"
    source = "thesis 3.1; the plank encoder sits on the pinion"
    what = (
        "Tooth errors and an eccentric pinion move the plank ahead and back while the pinion "
        "turns evenly. It is the same in every run, at zero slip too."
    )
    check = "Second encoder on the plank: the period is a tooth or a turn of the pinion."
    shown_by = "A run at zero slip: 200 N per mm."
    removes = "New pinion or rack; or the position of the plank from its own encoder."

    cos: float = param(
        0.0, unit="m", bounds=(-2e-3, 2e-3), screen=5e-5, matters=2e-5,
        title="cosine part", symbol="x_c",
        note="Cosine part over the plank position of the wave of the plank beside its encoder.",
    )  # fmt: skip
    sin: float = param(
        0.0, unit="m", bounds=(-2e-3, 2e-3), screen=5e-5, matters=2e-5,
        title="sine part", symbol="x_s",
        note="Sine part over the plank position of the wave of the plank beside its encoder.",
    )  # fmt: skip
    period: float = param(
        0.1, unit="m", bounds=(1.0 / SHORTEST, 1.2),
        title="period", symbol="λ", note="Plank travel of one wave.",
    )  # fmt: skip

    @classmethod
    def variants(cls, runs: RunSet, residual: np.ndarray) -> list[dict[str, float]]:
        return [{"period": p} for p in periods(runs, residual, 1.0 / SHORTEST, 1.2)]

    @classmethod
    def scanned(cls, runs: RunSet) -> int:
        return 530

    def motion(self, motion: Motion) -> None:
        phase = 2.0 * np.pi * motion.data.position / self.period
        # the measured motion is filtered, so this one must be, too
        damp = np.exp(-0.5 * (2.0 * np.pi * FILTER * SPEED / self.period) ** 2)
        wave = self.cos * (np.cos(phase) - 1.0) + self.sin * np.sin(phase)
        wave = damp * wave
        motion.travel += np.diff(wave, axis=-1, prepend=wave[..., :1])
