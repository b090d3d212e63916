# SPDX-License-Identifier: Apache-2.0
"""Tires that push to one side when they roll straight."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.sweep_base import SweepEffect


@dataclass(frozen=True)
class Conicity(SweepEffect):
    """Side force as a share of the load, at any slip angle.

    Source: Pacejka, Tire and Vehicle Dynamics (2012) section 4.1.5.
    """

    identifier = "conicity"
    title = "side force of a conical tire"
    kind = "tire"
    coordinate = "fz"
    needs = ("alpha", "fz")
    in_file = True
    what = "a conical tire pushes to its larger side, as camber does"
    check = "mount the tire the other way round: the force turns its sign"
    removes = "fit PVY1 and PVY2"
    share: float = param(
        0.0, unit="1", bounds=(-0.2, 0.2), screen=0.005, matters=0.001,
        title="conicity", symbol="q_y",
        note="Side force over load of the tire that rolls straight.",
    )  # fmt: skip

    def bench(self, s: Any) -> None:
        s.force = s.force + self.share * s.fz


@dataclass(frozen=True)
class PlySteer(SweepEffect):
    """A shift of the slip angle: ply steer, or a turned angle.

    Source: Pacejka, Tire and Vehicle Dynamics (2012) section 4.1.5.
    """

    identifier = "ply_steer"
    title = "slip angle of the plies"
    kind = "tire"
    coordinate = "alpha"
    needs = ("alpha",)
    in_file = True
    what = "the outermost ply steers the tire; a slip angle with a wrong zero looks the same"
    check = "turn the wheel round: ply steer keeps its sign"
    removes = "fit PHY1, or correct the zero of the steering angle"
    angle: float = param(
        0.0, unit="rad", bounds=(-0.05, 0.05), screen=0.001, matters=0.0002,
        title="angle of the plies", symbol="α_p", note="Slip angle by which the plies steer.",
    )  # fmt: skip

    def tire(self, s: Any) -> None:
        s.alpha = s.alpha + self.angle
