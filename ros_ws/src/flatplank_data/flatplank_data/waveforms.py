# SPDX-License-Identifier: Apache-2.0
"""Waveforms of slip over the road: each is a parameter set with a pure function of distance."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar

from flatplank_data.limits import LIMITS, SHARE
from flatplank_data.params import Params, param, parameter_infos

SLIP = LIMITS["kappa"].bounds
MAX_SLIP = SLIP[1]
LENGTH = (1e-3, 100.0)


def triangle(turns: float) -> float:
    """Triangle of period 1 between -1 and 1 that starts upwards from 0."""
    return 1.0 - 4.0 * abs((turns + 0.25) % 1.0 - 0.5)


@dataclass(frozen=True)
class Waveform(Params):
    """Slip over the distance since the start position; before it the tire rolls freely."""

    name: ClassVar[str]

    def slip(self, distance: float) -> float:
        """kappa [-] at `distance` >= 0 [m]; ISO W, driving > 0."""
        raise TypeError(f"{type(self).__name__} must define slip")


def in_words(wave: Params, given: Iterable[str]) -> str:
    """The given parameters of a waveform or profile, slips in percent."""
    words = []
    for info in parameter_infos(type(wave)):
        if info.name not in given:
            continue
        value = getattr(wave, info.name)
        plain = f"{value:g} {info.unit}".removesuffix(" -")
        amount = f"{100 * value:+g} %" if info.unit == SHARE else plain
        words.append(amount if info.name == "kappa" else f"{info.name} {amount}")
    return ", ".join(words) or "its defaults"


@dataclass(frozen=True)
class Wave(Waveform):
    """Periodic slip without end."""

    amplitude: float = param(0.0, "amplitude of the slip", unit=SHARE, bounds=SLIP)
    wavelength: float = param(1.0, "wavelength on the road", unit="m", bounds=LENGTH)
    offset: float = param(0.0, "mean slip", unit=SHARE, bounds=SLIP)

    def check(self) -> str | None:
        """Reason of a refusal when the largest slip is exceeded, else None."""
        peak = abs(self.offset) + abs(self.amplitude)
        if peak <= MAX_SLIP:
            return None
        return f"the slip reaches {100.0 * peak:g} %, beyond {100.0 * MAX_SLIP:g} %"


@dataclass(frozen=True)
class Constant(Waveform):
    """kappa from the start position to the end of the road; with start position 0 from the first
    motion on."""

    name = "constant"
    kappa: float = param(0.0, "slip", unit=SHARE, bounds=SLIP)

    def slip(self, distance: float) -> float:
        return self.kappa


@dataclass(frozen=True)
class Step(Waveform):
    """kappa after the step; back to free rolling after `length`."""

    name = "step"
    kappa: float = param(0.0, "slip after the step", unit=SHARE, bounds=SLIP)
    length: float = param(100.0, "length of the step", unit="m", bounds=LENGTH)

    def slip(self, distance: float) -> float:
        return self.kappa if distance < self.length else 0.0


@dataclass(frozen=True)
class DoubleStep(Waveform):
    """kappa_1 for `length`, then kappa_2."""

    name = "double_step"
    kappa_1: float = param(0.0, "slip after the first step", unit=SHARE, bounds=SLIP)
    kappa_2: float = param(0.0, "slip after the second step", unit=SHARE, bounds=SLIP)
    length: float = param(1.0, "road from the first step to the second", unit="m", bounds=LENGTH)

    def slip(self, distance: float) -> float:
        return self.kappa_1 if distance < self.length else self.kappa_2


@dataclass(frozen=True)
class Sine(Wave):
    """offset + amplitude sin(2 pi distance / wavelength)."""

    name = "sine"

    def slip(self, distance: float) -> float:
        return self.offset + self.amplitude * math.sin(math.tau * distance / self.wavelength)


@dataclass(frozen=True)
class Triangle(Wave):
    """offset + amplitude times a triangle of period `wavelength` that starts upwards from 0."""

    name = "triangle"

    def slip(self, distance: float) -> float:
        return self.offset + self.amplitude * triangle(distance / self.wavelength)


WAVEFORMS: dict[str, type[Waveform]] = {
    waveform.name: waveform for waveform in (Constant, Step, DoubleStep, Sine, Triangle)
}
