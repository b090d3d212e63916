# SPDX-License-Identifier: Apache-2.0
"""Rubber that is warmer than in the middle of the sweeps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.sweep_base import SweepEffect


@dataclass(frozen=True)
class GripOverTemperature(SweepEffect):
    """Friction changes by a share for each kelvin.

    Source: Grosch (1963), The relation between the friction and visco-elastic properties of
    rubber, Proc. R. Soc. A 274.
    """

    identifier = "grip_temperature"
    title = "friction follows the tread temperature"
    kind = "tire"
    coordinate = "temperature"
    needs = ("temperature",)
    what = "warm rubber has another friction"
    check = "repeat a sweep cold and warm"
    removes = "control the tread temperature, or give friction its coefficient"
    slope: float = param(
        0.0, unit="1/K", bounds=(-0.05, 0.05), screen=0.001, matters=0.0003,
        title="friction over temperature", symbol="q_μT",
        note="Relative change of the friction for a kelvin.",
    )  # fmt: skip

    def tire(self, s: Any) -> None:
        s.grip = s.grip * np.exp(self.slope * s.above("temperature"))


@dataclass(frozen=True)
class StiffnessOverTemperature(SweepEffect):
    """Slip stiffness changes by a share for each kelvin.

    Source: Ferry (1980), Viscoelastic Properties of Polymers: the modulus falls with temperature.
    """

    identifier = "stiffness_temperature"
    title = "slip stiffness follows the tread temperature"
    kind = "tire"
    coordinate = "temperature"
    needs = ("temperature",)
    what = "warm rubber is softer"
    check = "repeat a sweep of small slip cold and warm"
    removes = "control the tread temperature, or give the stiffness its coefficient"
    slope: float = param(
        0.0, unit="1/K", bounds=(-0.05, 0.05), screen=0.001, matters=0.0003,
        title="slip stiffness over temperature", symbol="q_KT",
        note="Relative change of the slip stiffness for a kelvin.",
    )  # fmt: skip

    def tire(self, s: Any) -> None:
        s.stiffness = s.stiffness * np.exp(self.slope * s.above("temperature"))
