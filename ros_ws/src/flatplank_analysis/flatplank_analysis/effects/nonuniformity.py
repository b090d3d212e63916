# SPDX-License-Identifier: Apache-2.0
"""Non-uniformity of the tire, orders 1 to 3."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Signal, TireEffect
from flatplank_analysis.effects.waves import wave


@dataclass(frozen=True)
class NonUniformity1(TireEffect):
    """The rolling tire makes a force that waves 1 time per turn and grows with the load.

    Source: tire uniformity practice
    """

    identifier = "nonuniformity_1"
    title = "Non-uniformity of the tire, order 1"
    kind = "tire"
    coordinate = "wheel angle"
    source = "tire uniformity practice"
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
class NonUniformity2(TireEffect):
    """The rolling tire makes a force that waves 2 times per turn and grows with the load.

    Source: tire uniformity practice
    """

    identifier = "nonuniformity_2"
    title = "Non-uniformity of the tire, order 2"
    kind = "tire"
    coordinate = "wheel angle"
    source = "tire uniformity practice"
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
class NonUniformity3(TireEffect):
    """The rolling tire makes a force that waves 3 times per turn and grows with the load.

    Source: tire uniformity practice
    """

    identifier = "nonuniformity_3"
    title = "Non-uniformity of the tire, order 3"
    kind = "tire"
    coordinate = "wheel angle"
    source = "tire uniformity practice"
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
