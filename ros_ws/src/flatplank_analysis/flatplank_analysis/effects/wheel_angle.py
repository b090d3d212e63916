# SPDX-License-Identifier: Apache-2.0
"""Forces and radii that turn with the wheel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Motion, Signal, Tire, TireEffect
from flatplank_analysis.effects.waves import wave


@dataclass(frozen=True)
class ParasiticForce(TireEffect):
    """Once per turn of the wheel, the same at every slip and load, in the forces that the hub shows.

    Source: thesis Appendix C: about 300 N before, 15-25 N after the correction
    """

    identifier = "parasitic_force"
    title = "Parasitic force of the preloaded shaft"
    kind = "machine"
    coordinate = "wheel angle"
    source = "thesis Appendix C: about 300 N before, 15-25 N after the correction"
    what = (
        "The shaft is bent or the flexplates are preloaded: the hub feels a force that turns "
        "with the wheel, even when the wheel is lifted."
    )
    check = "Turn the unloaded wheel three times and look at the forces."
    removes = "The parasitic filter with a fresh three-turn run; a longer flexplate drum."
    main = "fx_cos"

    fx_cos: float = param(0.0, unit="N", bounds=(-500.0, 500.0), screen=20.0, matters=5.0)
    fx_sin: float = param(0.0, unit="N", bounds=(-500.0, 500.0), screen=20.0, matters=5.0)
    fz_cos: float = param(0.0, unit="N", bounds=(-500.0, 500.0), screen=20.0)
    fz_sin: float = param(0.0, unit="N", bounds=(-500.0, 500.0), screen=20.0)

    @classmethod
    def size(cls, values: dict[str, float]) -> float:
        return float(np.hypot(values["fx_cos"], values["fx_sin"]))

    def tire(self, tire: Tire) -> None:
        # the load channel shows a force that the tire does not feel
        tire.load -= wave(tire.data.wheel_turn, 1, self.fz_cos, self.fz_sin)

    def signal(self, signal: Signal) -> None:
        angle = signal.data.wheel_turn
        signal.fx = signal.fx + wave(angle, 1, self.fx_cos, self.fx_sin)
        signal.fz = signal.fz + wave(angle, 1, self.fz_cos, self.fz_sin)


@dataclass(frozen=True)
class NonUniformity1(TireEffect):
    """The rolling tire makes a force that waves 1 time per turn and grows with the load.

    Source: tire uniformity practice; REFERENCE 6
    """

    identifier = "nonuniformity_1"
    title = "Non-uniformity of the tire, order 1"
    kind = "tire"
    coordinate = "wheel angle"
    source = "tire uniformity practice; REFERENCE 6"
    what = (
        "The tire is not even around its circumference: tangential and radial force wave with "
        "the wheel angle while it rolls under load."
    )
    check = (
        "Turn the tire on the rim by 180 deg: the wave goes with the tire. Unloaded turn: no wave."
    )
    removes = "A more even tire; measure at all start angles and take the mean."
    main = "fx_cos"

    fx_cos: float = param(0.0, unit="N", bounds=(-500.0, 500.0), screen=20.0, matters=5.0)
    fx_sin: float = param(0.0, unit="N", bounds=(-500.0, 500.0), screen=20.0, matters=5.0)
    fz_cos: float = param(0.0, unit="N", bounds=(-500.0, 500.0), screen=20.0)
    fz_sin: float = param(0.0, unit="N", bounds=(-500.0, 500.0), screen=20.0)

    @classmethod
    def size(cls, values: dict[str, float]) -> float:
        return float(np.hypot(values["fx_cos"], values["fx_sin"]))

    def signal(self, signal: Signal) -> None:
        data = signal.data
        grow = (data.nominal / np.median(data.nominal))[:, None] * (data.position > 0.0005)
        signal.fx = signal.fx + grow * wave(data.wheel_turn, 1, self.fx_cos, self.fx_sin)
        signal.fz = signal.fz + grow * wave(data.wheel_turn, 1, self.fz_cos, self.fz_sin)


@dataclass(frozen=True)
class RunOut1(TireEffect):
    """The rolling radius waves 1 time per turn: slip and load wave with it.

    Source: REFERENCE 6: run-out turns with the start angle
    """

    identifier = "runout_1"
    title = "Run-out of wheel and tire, order 1"
    kind = "machine"
    coordinate = "wheel angle"
    source = "REFERENCE 6: run-out turns with the start angle"
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
        0.0, unit="N/m", bounds=(-4e5, 4e5), note="load per change of rolling radius"
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
class NonUniformity2(TireEffect):
    """The rolling tire makes a force that waves 2 times per turn and grows with the load.

    Source: tire uniformity practice; REFERENCE 6
    """

    identifier = "nonuniformity_2"
    title = "Non-uniformity of the tire, order 2"
    kind = "tire"
    coordinate = "wheel angle"
    source = "tire uniformity practice; REFERENCE 6"
    what = (
        "The tire is not even around its circumference: tangential and radial force wave with "
        "the wheel angle while it rolls under load."
    )
    check = (
        "Turn the tire on the rim by 180 deg: the wave goes with the tire. Unloaded turn: no wave."
    )
    removes = "A more even tire; measure at all start angles and take the mean."
    main = "fx_cos"

    fx_cos: float = param(0.0, unit="N", bounds=(-500.0, 500.0), screen=20.0, matters=5.0)
    fx_sin: float = param(0.0, unit="N", bounds=(-500.0, 500.0), screen=20.0, matters=5.0)
    fz_cos: float = param(0.0, unit="N", bounds=(-500.0, 500.0), screen=20.0)
    fz_sin: float = param(0.0, unit="N", bounds=(-500.0, 500.0), screen=20.0)

    @classmethod
    def size(cls, values: dict[str, float]) -> float:
        return float(np.hypot(values["fx_cos"], values["fx_sin"]))

    def signal(self, signal: Signal) -> None:
        data = signal.data
        grow = (data.nominal / np.median(data.nominal))[:, None] * (data.position > 0.0005)
        signal.fx = signal.fx + grow * wave(data.wheel_turn, 2, self.fx_cos, self.fx_sin)
        signal.fz = signal.fz + grow * wave(data.wheel_turn, 2, self.fz_cos, self.fz_sin)


@dataclass(frozen=True)
class RunOut2(TireEffect):
    """The rolling radius waves 2 times per turn: slip and load wave with it.

    Source: REFERENCE 6: run-out turns with the start angle
    """

    identifier = "runout_2"
    title = "Run-out of wheel and tire, order 2"
    kind = "machine"
    coordinate = "wheel angle"
    source = "REFERENCE 6: run-out turns with the start angle"
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
        0.0, unit="N/m", bounds=(-4e5, 4e5), note="load per change of rolling radius"
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
class NonUniformity3(TireEffect):
    """The rolling tire makes a force that waves 3 times per turn and grows with the load.

    Source: tire uniformity practice; REFERENCE 6
    """

    identifier = "nonuniformity_3"
    title = "Non-uniformity of the tire, order 3"
    kind = "tire"
    coordinate = "wheel angle"
    source = "tire uniformity practice; REFERENCE 6"
    what = (
        "The tire is not even around its circumference: tangential and radial force wave with "
        "the wheel angle while it rolls under load."
    )
    check = (
        "Turn the tire on the rim by 180 deg: the wave goes with the tire. Unloaded turn: no wave."
    )
    removes = (
        "A more even tire; measure at all start angles and take the mean (order 3 stays in it)."
    )
    main = "fx_cos"

    fx_cos: float = param(0.0, unit="N", bounds=(-500.0, 500.0), screen=20.0, matters=5.0)
    fx_sin: float = param(0.0, unit="N", bounds=(-500.0, 500.0), screen=20.0, matters=5.0)
    fz_cos: float = param(0.0, unit="N", bounds=(-500.0, 500.0), screen=20.0)
    fz_sin: float = param(0.0, unit="N", bounds=(-500.0, 500.0), screen=20.0)

    @classmethod
    def size(cls, values: dict[str, float]) -> float:
        return float(np.hypot(values["fx_cos"], values["fx_sin"]))

    def signal(self, signal: Signal) -> None:
        data = signal.data
        grow = (data.nominal / np.median(data.nominal))[:, None] * (data.position > 0.0005)
        signal.fx = signal.fx + grow * wave(data.wheel_turn, 3, self.fx_cos, self.fx_sin)
        signal.fz = signal.fz + grow * wave(data.wheel_turn, 3, self.fz_cos, self.fz_sin)


@dataclass(frozen=True)
class RunOut3(TireEffect):
    """The rolling radius waves 3 times per turn: slip and load wave with it.

    Source: REFERENCE 6: run-out turns with the start angle
    """

    identifier = "runout_3"
    title = "Run-out of wheel and tire, order 3"
    kind = "machine"
    coordinate = "wheel angle"
    source = "REFERENCE 6: run-out turns with the start angle"
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
        0.0, unit="N/m", bounds=(-4e5, 4e5), note="load per change of rolling radius"
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
