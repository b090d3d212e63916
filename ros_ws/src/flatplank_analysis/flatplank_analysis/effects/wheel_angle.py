# SPDX-License-Identifier: Apache-2.0
"""Forces and slip that vary with the wheel angle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Motion, Signal, Tire, TireEffect, Wave


def wave(angle: np.ndarray, order: int, cos: np.ndarray, sin: np.ndarray) -> np.ndarray:
    """Wave of an order over the angle [rad] with the amplitudes cos and sin."""
    return cos * np.cos(order * angle) + sin * np.sin(order * angle)


@dataclass(frozen=True)
class TurningForce(TireEffect):
    """Forces in x and z that vary with the wheel angle; the size is the amplitude in x."""

    coordinate = "wheel angle"

    fx_cos: float = param(
        0.0, unit="N", bounds=(-500.0, 500.0), screen=20.0, matters=5.0,
        title="cosine part in x", symbol="F_xc",
        note="Cosine part over the wheel angle of the wave of Fx.",
    )  # fmt: skip
    fx_sin: float = param(
        0.0, unit="N", bounds=(-500.0, 500.0), screen=20.0, matters=5.0,
        title="sine part in x", symbol="F_xs",
        note="Sine part over the wheel angle of the wave of Fx.",
    )  # fmt: skip
    fz_cos: float = param(
        0.0, unit="N", bounds=(-500.0, 500.0), screen=20.0,
        title="cosine part in z", symbol="F_zc",
        note="Cosine part over the wheel angle of the wave of Fz.",
    )  # fmt: skip
    fz_sin: float = param(
        0.0, unit="N", bounds=(-500.0, 500.0), screen=20.0,
        title="sine part in z", symbol="F_zs",
        note="Sine part over the wheel angle of the wave of Fz.",
    )  # fmt: skip

    @classmethod
    def size(cls, values: dict[str, float]) -> float:
        return float(np.hypot(values["fx_cos"], values["fx_sin"]))


@dataclass(frozen=True)
class ParasiticForce(TurningForce):
    """The readings of the hub vary once per turn of the wheel, equally at every slip and load."""

    identifier = "parasitic_force"
    title = "Parasitic force of the preloaded shaft"
    source = "thesis Appendix C: about 300 N before, 15-25 N after the correction"
    what = (
        "The shaft is bent or the flexplates are preloaded: a force acts on the hub that turns "
        "with the wheel, even when the wheel is lifted."
    )
    check = "Turn the unloaded wheel three times and look at the forces."
    removes = "The parasitic filter with a fresh three-turn run; a longer flexplate drum."

    def tire(self, tire: Tire) -> None:
        # the load channel reads a force that does not act on the tire
        tire.load -= wave(tire.data.wheel_turn, 1, self.fz_cos, self.fz_sin)

    def signal(self, signal: Signal) -> None:
        angle = signal.data.wheel_turn
        signal.fx = signal.fx + wave(angle, 1, self.fx_cos, self.fx_sin)
        signal.fz = signal.fz + wave(angle, 1, self.fz_cos, self.fz_sin)


@dataclass(frozen=True)
class NonUniformity(TurningForce):
    """The rolling tire makes a force that varies over the turn and grows with the load."""

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
    """periods per turn of the wheel"""

    def signal(self, signal: Signal) -> None:
        data = signal.data
        grow = data.relative_load[:, None] * (data.position > 0.0005)
        turn, order = data.wheel_turn, self.per_turn
        signal.fx = signal.fx + grow * wave(turn, order, self.fx_cos, self.fx_sin)
        signal.fz = signal.fz + grow * wave(turn, order, self.fz_cos, self.fz_sin)


@dataclass(frozen=True)
class NonUniformity1(NonUniformity):
    """One period per turn of the wheel."""

    identifier = "nonuniformity_1"
    title = "Non-uniformity of the tire, order 1"
    per_turn = 1


@dataclass(frozen=True)
class NonUniformity2(NonUniformity):
    """Two periods per turn."""

    identifier = "nonuniformity_2"
    title = "Non-uniformity of the tire, order 2"
    per_turn = 2


@dataclass(frozen=True)
class NonUniformity3(NonUniformity):
    """Three periods per turn: the same at all three start angles."""

    identifier = "nonuniformity_3"
    title = "Non-uniformity of the tire, order 3"
    per_turn = 3
    removes = f"{NonUniformity.removes[:-1]} (order 3 stays in it)."


@dataclass(frozen=True)
class RunOut(Wave):
    """The rolling radius varies over the turn, and slip and load with it."""

    per_turn: ClassVar[int]
    """periods per turn of the wheel"""
    coordinate = "wheel angle"
    source = "thesis 3.1: run-out turns with the start angle"
    what = (
        "Rim or tire run out of true: the rolling radius changes with the wheel angle, and "
        "with it the slip; the fixed axle height turns it into load."
    )
    check = "Dial gauge on the rim and on the tread over one turn."
    removes = "True the rim on its hub; measure at all start angles."

    cos: float = param(
        0.0, unit="m", bounds=(-3e-3, 3e-3), screen=2e-4, matters=5e-5,
        title="cosine part", symbol="r_c",
        note="Cosine part over the wheel angle of the wave of the rolling radius.",
    )  # fmt: skip
    sin: float = param(
        0.0, unit="m", bounds=(-3e-3, 3e-3), screen=2e-4, matters=5e-5,
        title="sine part", symbol="r_s",
        note="Sine part over the wheel angle of the wave of the rolling radius.",
    )  # fmt: skip
    radial: float = param(
        0.0, unit="N/m", bounds=(-2e6, 2e6),
        title="radial stiffness", symbol="c_r",
        note="Change of the load over that of the rolling radius; the radius changes by a third "
             "of the run-out or less.",
    )  # fmt: skip

    def motion(self, motion: Motion) -> None:
        data = motion.data
        change = wave(data.wheel_turn, self.per_turn, self.cos, self.sin)
        motion.rolled += change * data.turned

    def signal(self, signal: Signal) -> None:
        change = wave(signal.data.wheel_turn, self.per_turn, self.cos, self.sin)
        signal.fz = signal.fz + self.radial * change


@dataclass(frozen=True)
class RunOut1(RunOut):
    """One period per turn of the wheel."""

    identifier = "runout_1"
    title = "Run-out of wheel and tire, order 1"
    per_turn = 1


@dataclass(frozen=True)
class RunOut2(RunOut):
    """Two periods per turn."""

    identifier = "runout_2"
    title = "Run-out of wheel and tire, order 2"
    per_turn = 2


@dataclass(frozen=True)
class RunOut3(RunOut):
    """Three periods per turn: the same at all three start angles."""

    identifier = "runout_3"
    title = "Run-out of wheel and tire, order 3"
    per_turn = 3
    removes = f"{RunOut.removes[:-1]} (order 3 is the same in all three)."
