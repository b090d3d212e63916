# SPDX-License-Identifier: Apache-2.0
"""Lateral forces and angles of tire and steering."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.contact_patch.parameters import PROTRACTOR
from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Motion, Signal, Tire, TireEffect, TireProperty


@dataclass(frozen=True)
class CamberThrust(TireProperty):
    """Camber acts like a slip angle."""

    identifier = "camber_thrust"
    title = "Camber thrust"
    coordinate = "slip level"
    source = "thesis 6.3, figures 6.16 and 6.17"
    what = "A cambered tire pulls sideways."
    check = "Nothing to check on the machine."
    shown_by = "Runs at two camber angles."

    share: float = param(
        0.0, unit="1", bounds=(-0.5, 0.5), screen=0.05, matters=0.01,
        title="camber thrust", symbol="ε_γ",
        note="Slip angle that gives the same side force, over the camber.",
    )  # fmt: skip

    def motion(self, motion: Motion) -> None:
        camber = np.sin(motion.data.gamma)[:, None]
        motion.lateral -= self.share * camber * motion.travel


@dataclass(frozen=True)
class Conicity(TireProperty):
    """The tire is a cone: a lateral force proportional to the load that keeps its sign when the
    direction of travel changes."""

    identifier = "conicity"
    title = "Conicity"
    rarity = 1
    coordinate = "load"
    source = "tire uniformity practice (ISO 8855 terms)"
    what = "The belt sits off centre: the tire pulls to one side."
    check = "Turn the tire on the rim: conicity changes its sign."

    share: float = param(
        0.0, unit="1", bounds=(-0.05, 0.05), screen=0.003, matters=0.002,
        title="conicity", symbol="q_y", note="Side force over load of the rolling tire.",
    )  # fmt: skip

    def signal(self, signal: Signal) -> None:
        data = signal.data
        signal.fy = signal.fy + self.share * data.load * (data.position > 0.0005)


@dataclass(frozen=True)
class PlySteer(TireProperty):
    """The belt steers: a lateral force at zero slip angle that changes sign with the direction of
    travel."""

    identifier = "ply_steer"
    title = "Ply steer"
    rarity = 1
    in_base = PROTRACTOR
    coordinate = "slip level"
    source = "tire uniformity practice (ISO 8855 terms)"
    what = "The cords of the belt make the tire roll at an angle."
    check = "Turn the tire on the rim: ply steer keeps its sign, conicity does not."
    shown_by = "A reversed run: ply steer changes its sign, conicity does not."

    angle: float = param(
        0.0, unit="rad", bounds=(-0.02, 0.02), screen=1e-3, matters=PROTRACTOR,
        title="angle of the plies", symbol="α_p",
        note="Slip angle by which the plies steer; less is within what the base allows the "
             "protractor.",
    )  # fmt: skip

    def motion(self, motion: Motion) -> None:
        motion.lateral += self.angle * motion.travel


@dataclass(frozen=True)
class SteeringZero(TireEffect):
    """The steering angle has a constant error."""

    identifier = "steering_zero"
    title = "Zero error of the steering angle"
    in_base = PROTRACTOR
    coordinate = "slip level"
    source = "thesis Table I.1: Fy = 0 at 1.0 deg"
    what = (
        "The steering is not straight at its zero. With one direction of travel it cannot be "
        "told from ply steer."
    )
    check = "Straight edge along the rim."
    shown_by = "A reversed run."
    removes = "Set the slip angle offset in the parameters."

    zero: float = param(
        0.0, unit="rad", bounds=(-0.05, 0.05), screen=2e-3, matters=PROTRACTOR,
        title="zero of the steering", symbol="α_0",
        note="Steering angle at the reading of zero; less is within what the base allows the "
             "protractor.",
    )  # fmt: skip

    def motion(self, motion: Motion) -> None:
        motion.lateral -= self.zero * motion.travel


@dataclass(frozen=True)
class SteeringPlay(TireEffect):
    """The steering angle changes with the lateral force, within its play."""

    identifier = "steering_play"
    title = "Play of the steering"
    coordinate = "slip level"
    source = "thesis 3.1: 0.2 deg of play"
    what = (
        "The steering has play: the wheel turns with the pull of the tire until it meets the "
        "other flank."
    )
    check = "Dial gauge at the rim, push and pull at the tire."
    removes = "Clamp the steering during the run."

    play: float = param(
        0.0, unit="rad", bounds=(0.0, 0.03), screen=1.7e-3, matters=5e-4,
        title="half of the play", symbol="δ_α", note="Half of the free angle of the steering.",
    )  # fmt: skip

    def tire(self, tire: Tire) -> None:
        tire.y.follow += self.per_run.play
