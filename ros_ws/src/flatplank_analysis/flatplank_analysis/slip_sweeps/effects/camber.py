# SPDX-License-Identifier: Apache-2.0
"""Camber acts otherwise than the file says."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.sweep_base import SweepEffect


@dataclass(frozen=True)
class CamberThrust(SweepEffect):
    """Side force of the camber, as a share of the load.

    Source: Pacejka, Tire and Vehicle Dynamics (2012) equation 4.E30.
    """

    identifier = "camber_thrust"
    title = "camber thrust differs from the tire file"
    kind = "tire"
    coordinate = "gamma"
    needs = ("gamma",)
    in_file = True
    what = "a leaning tire pushes to its side, by more or less than the file says"
    check = "sweep at two cambers of both signs"
    removes = "fit PKY6 and PVY3 to sweeps at several cambers"
    thrust: float = param(
        0.0, unit="1/rad", bounds=(-3.0, 3.0), screen=0.05, matters=0.01,
        title="camber thrust", symbol="c_γ",
        note="Side force over load for a radian of camber, beside that of the tire file.",
    )  # fmt: skip

    def bench(self, s: Any) -> None:
        s.force = s.force + self.thrust * s.fz * s.gamma


@dataclass(frozen=True)
class StiffnessOverCamber(SweepEffect):
    """Slip stiffness falls by a share for each radian of camber.

    Source: Pacejka, Tire and Vehicle Dynamics (2012) equation 4.E25, PKY3.
    """

    identifier = "camber_stiffness"
    title = "cornering stiffness falls with camber"
    kind = "tire"
    coordinate = "gamma"
    needs = ("gamma",)
    in_file = True
    what = "a leaning tire has a shorter contact"
    check = "sweep at two cambers"
    removes = "fit PKY3 to sweeps at several cambers"
    fall: float = param(
        0.0, unit="1/rad", bounds=(-5.0, 5.0), screen=0.1, matters=0.02,
        title="fall over camber", symbol="q_γ",
        note="Share of the slip stiffness that a radian of camber takes.",
    )  # fmt: skip

    def tire(self, s: Any) -> None:
        s.stiffness = s.stiffness * (1.0 - self.fall * np.abs(s.gamma))
