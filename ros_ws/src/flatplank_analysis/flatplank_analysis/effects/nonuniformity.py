# SPDX-License-Identifier: Apache-2.0
"""Non-uniformity of the tire, orders 1 to 3."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from flatplank_analysis.effects.base import Signal
from flatplank_analysis.effects.turning_force import TurningForce
from flatplank_analysis.effects.waves import wave


@dataclass(frozen=True)
class NonUniformity(TurningForce):
    """The rolling tire makes a force that waves over the turn and grows with the load."""

    kind = "tire"
    source = "tire uniformity practice"
    what = (
        "The tire is not even around its circumference: tangential and radial force wave with "
        "the wheel angle while it rolls under load."
    )
    check = (
        "Turn the tire on the rim by 180 deg: the wave goes with the tire. Unloaded turn: no wave."
    )
    removes = "A more even tire; measure at all start angles and take the mean."
    per_turn: ClassVar[int]
    """waves in a turn of the wheel"""

    def signal(self, signal: Signal) -> None:
        data = signal.data
        grow = (data.nominal / data.reference.load)[:, None] * (data.position > 0.0005)
        turn, order = data.wheel_turn, self.per_turn
        signal.fx = signal.fx + grow * wave(turn, order, self.fx_cos, self.fx_sin)
        signal.fz = signal.fz + grow * wave(turn, order, self.fz_cos, self.fz_sin)


@dataclass(frozen=True)
class NonUniformity1(NonUniformity):
    """One wave in a turn of the wheel."""

    identifier = "nonuniformity_1"
    title = "Non-uniformity of the tire, order 1"
    per_turn = 1


@dataclass(frozen=True)
class NonUniformity2(NonUniformity):
    """Two waves in a turn."""

    identifier = "nonuniformity_2"
    title = "Non-uniformity of the tire, order 2"
    per_turn = 2


@dataclass(frozen=True)
class NonUniformity3(NonUniformity):
    """Three waves in a turn: the same at all three start angles."""

    identifier = "nonuniformity_3"
    title = "Non-uniformity of the tire, order 3"
    per_turn = 3
    removes = f"{NonUniformity.removes[:-1]} (order 3 stays in it)."
