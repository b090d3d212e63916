# SPDX-License-Identifier: Apache-2.0
"""Run-out of wheel and tire, orders 1 to 3."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Motion, Signal, TireEffect
from flatplank_analysis.effects.waves import wave


@dataclass(frozen=True)
class RunOut(TireEffect):
    """The rolling radius waves over the turn: slip and load wave with it."""

    per_turn: ClassVar[int]
    """waves in a turn of the wheel"""
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
        change = wave(data.wheel_turn, self.per_turn, self.cos, self.sin)
        motion.rolled += change * data.turned

    def signal(self, signal: Signal) -> None:
        change = wave(signal.data.wheel_turn, self.per_turn, self.cos, self.sin)
        signal.fz = signal.fz + self.radial * change


@dataclass(frozen=True)
class RunOut1(RunOut):
    """One wave in a turn of the wheel."""

    identifier = "runout_1"
    title = "Run-out of wheel and tire, order 1"
    per_turn = 1


@dataclass(frozen=True)
class RunOut2(RunOut):
    """Two waves in a turn."""

    identifier = "runout_2"
    title = "Run-out of wheel and tire, order 2"
    per_turn = 2


@dataclass(frozen=True)
class RunOut3(RunOut):
    """Three waves in a turn: the same at all three start angles."""

    identifier = "runout_3"
    title = "Run-out of wheel and tire, order 3"
    per_turn = 3
    removes = f"{RunOut.removes[:-1]} (order 3 is the same in all three)."
