# SPDX-License-Identifier: Apache-2.0
"""Run-out of wheel and tire, orders 1 to 3."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Motion, Signal, TireEffect
from flatplank_analysis.effects.waves import wave


@dataclass(frozen=True)
class RunOut1(TireEffect):
    """The rolling radius waves 1 time per turn: slip and load wave with it.

    Source: thesis 3.1: run-out turns with the start angle
    """

    identifier = "runout_1"
    title = "Run-out of wheel and tire, order 1"
    kind = "machine"
    coordinate = "wheel angle"
    source = "thesis 3.1: run-out turns with the start angle"
    what = (
        "Rim or tire run out of true: the rolling radius changes with the wheel angle, and "
        "with it the slip; the fixed axle height turns it into load."
    )
    check = "Dial gauge on the rim and on the tread over one turn."
    removes = "True the rim on its hub; measure at all start angles."
    main = "cos"

    cos: float = param(
        0.0,
        unit="m",
        bounds=(-3e-3, 3e-3),
        screen=2e-4,
        matters=5e-5,
        note="amplitude of the rolling radius",
    )
    sin: float = param(0.0, unit="m", bounds=(-3e-3, 3e-3), screen=2e-4, matters=5e-5)
    radial: float = param(
        0.0,
        unit="N/m",
        bounds=(-2e6, 2e6),
        note="load per change of rolling radius; that changes by a third of the run-out or less",
    )

    @classmethod
    def size(cls, values: dict[str, float]) -> float:
        return float(np.hypot(values["cos"], values["sin"]))

    def motion(self, motion: Motion) -> None:
        data = motion.data
        change = wave(data.wheel_turn, 1, self.cos, self.sin)
        motion.rolled += change * data.turned

    def signal(self, signal: Signal) -> None:
        change = wave(signal.data.wheel_turn, 1, self.cos, self.sin)
        signal.fz = signal.fz + self.radial * change


@dataclass(frozen=True)
class RunOut2(TireEffect):
    """The rolling radius waves 2 times per turn: slip and load wave with it.

    Source: thesis 3.1: run-out turns with the start angle
    """

    identifier = "runout_2"
    title = "Run-out of wheel and tire, order 2"
    kind = "machine"
    coordinate = "wheel angle"
    source = "thesis 3.1: run-out turns with the start angle"
    what = (
        "Rim or tire run out of true: the rolling radius changes with the wheel angle, and "
        "with it the slip; the fixed axle height turns it into load."
    )
    check = "Dial gauge on the rim and on the tread over one turn."
    removes = "True the rim on its hub; measure at all start angles."
    main = "cos"

    cos: float = param(
        0.0,
        unit="m",
        bounds=(-3e-3, 3e-3),
        screen=2e-4,
        matters=5e-5,
        note="amplitude of the rolling radius",
    )
    sin: float = param(0.0, unit="m", bounds=(-3e-3, 3e-3), screen=2e-4, matters=5e-5)
    radial: float = param(
        0.0,
        unit="N/m",
        bounds=(-2e6, 2e6),
        note="load per change of rolling radius; that changes by a third of the run-out or less",
    )

    @classmethod
    def size(cls, values: dict[str, float]) -> float:
        return float(np.hypot(values["cos"], values["sin"]))

    def motion(self, motion: Motion) -> None:
        data = motion.data
        change = wave(data.wheel_turn, 2, self.cos, self.sin)
        motion.rolled += change * data.turned

    def signal(self, signal: Signal) -> None:
        change = wave(signal.data.wheel_turn, 2, self.cos, self.sin)
        signal.fz = signal.fz + self.radial * change


@dataclass(frozen=True)
class RunOut3(TireEffect):
    """The rolling radius waves 3 times per turn: slip and load wave with it.

    Source: thesis 3.1: run-out turns with the start angle
    """

    identifier = "runout_3"
    title = "Run-out of wheel and tire, order 3"
    kind = "machine"
    coordinate = "wheel angle"
    source = "thesis 3.1: run-out turns with the start angle"
    what = (
        "Rim or tire run out of true: the rolling radius changes with the wheel angle, and "
        "with it the slip; the fixed axle height turns it into load."
    )
    check = "Dial gauge on the rim and on the tread over one turn."
    removes = (
        "True the rim on its hub; measure at all start angles (order 3 is the same in all three)."
    )
    main = "cos"

    cos: float = param(
        0.0,
        unit="m",
        bounds=(-3e-3, 3e-3),
        screen=2e-4,
        matters=5e-5,
        note="amplitude of the rolling radius",
    )
    sin: float = param(0.0, unit="m", bounds=(-3e-3, 3e-3), screen=2e-4, matters=5e-5)
    radial: float = param(
        0.0,
        unit="N/m",
        bounds=(-2e6, 2e6),
        note="load per change of rolling radius; that changes by a third of the run-out or less",
    )

    @classmethod
    def size(cls, values: dict[str, float]) -> float:
        return float(np.hypot(values["cos"], values["sin"]))

    def motion(self, motion: Motion) -> None:
        data = motion.data
        change = wave(data.wheel_turn, 3, self.cos, self.sin)
        motion.rolled += change * data.turned

    def signal(self, signal: Signal) -> None:
        change = wave(signal.data.wheel_turn, 3, self.cos, self.sin)
        signal.fz = signal.fz + self.radial * change
