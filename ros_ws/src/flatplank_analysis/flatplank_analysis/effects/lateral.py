# SPDX-License-Identifier: Apache-2.0
"""Steering, side support and side force of the tire."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Motion, Signal, Tire, TireEffect


@dataclass(frozen=True)
class SteeringPlay(TireEffect):
    """The steering angle follows the pull of the tire through its play.

    Source: thesis 3.1: 0.2 deg of play
    """

    identifier = "steering_play"
    title = "Play of the steering"
    kind = "machine"
    coordinate = "slip level"
    source = "thesis 3.1: 0.2 deg of play"
    what = (
        "The steering has play: the wheel turns with the pull of the tire until it meets the "
        "other flank."
    )
    check = "Dial gauge at the rim, push and pull at the tire."
    removes = "Clamp the steering during the run."

    play: float = param(
        0.0,
        unit="rad",
        bounds=(0.0, 0.03),
        screen=1.7e-3,
        matters=5e-4,
        note="half of the free angle",
    )

    def tire(self, tire: Tire) -> None:
        tire.y.follow += self.per_run.play


@dataclass(frozen=True)
class SteeringZero(TireEffect):
    """The steering angle is off by a constant.

    Source: thesis Table I.1: Fy = 0 at 1.0 deg
    """

    identifier = "steering_zero"
    title = "Zero error of the steering angle"
    kind = "machine"
    coordinate = "slip level"
    source = "thesis Table I.1: Fy = 0 at 1.0 deg"
    what = (
        "The steering is not straight at its zero. With one direction of travel it cannot be "
        "told from ply steer."
    )
    check = "Straight edge along the rim; reversed run."
    removes = "Set the slip angle offset in the parameters."

    zero: float = param(0.0, unit="rad", bounds=(-0.05, 0.05), screen=2e-3, matters=1e-3)

    def motion(self, motion: Motion) -> None:
        motion.lateral -= self.zero * motion.travel


@dataclass(frozen=True)
class SupportPlayY(TireEffect):
    """The support slides sideways through its play while the lateral force passes zero.

    Source: thesis 3.1: 3 mm in y
    """

    identifier = "support_play_y"
    title = "Play of the support in y"
    kind = "machine"
    coordinate = "distance since the step"
    source = "thesis 3.1: 3 mm in y"
    what = (
        "The rotation support has side play: small lateral forces do not build up until it is "
        "taken up."
    )
    check = "Dial gauge at the support, push sideways."
    removes = "New bearings of the rotation support."
    main = "gap"

    gap: float = param(0.0, unit="m", bounds=(0.0, 6e-3), screen=5e-4, matters=2e-4)

    def tire(self, tire: Tire) -> None:
        tire.y.play += self.per_run.gap


@dataclass(frozen=True)
class SupportPlayZ(TireEffect):
    """The axle drops or rises by its play when the longitudinal force changes sides.

    Source: thesis 3.1: 1.3 mm in z
    """

    identifier = "support_play_z"
    title = "Play of the support in z"
    kind = "machine"
    coordinate = "slip level"
    source = "thesis 3.1: 1.3 mm in z"
    what = (
        "The support has play in z: the torque reaction moves the axle from one side to the "
        "other, and the load with it."
    )
    check = "Dial gauge at the axle during a change from braking to driving."
    removes = "New bearings of the rotation support."

    gap: float = param(
        0.0,
        unit="m",
        bounds=(-2e-3, 2e-3),
        screen=2e-4,
        matters=1e-4,
        note="change of axle height",
    )

    def signal(self, signal: Signal) -> None:
        # vertical stiffness of the tire, thesis Table 7.2
        side = np.tanh(signal.true_fx / 200.0)
        signal.fz = signal.fz + 0.5 * 2.13e5 * self.gap * side


@dataclass(frozen=True)
class CamberThrust(TireEffect):
    """Camber acts like a slip angle.

    Source: thesis 6.3, figures 6.16 and 6.17
    """

    identifier = "camber_thrust"
    title = "Camber thrust"
    kind = "tire"
    coordinate = "slip level"
    source = "thesis 6.3, figures 6.16 and 6.17"
    what = "A cambered tire pulls sideways."
    check = "Runs at two camber angles."
    removes = "Nothing: it belongs to the tire."

    share: float = param(
        0.0,
        unit="1",
        bounds=(-0.5, 0.5),
        screen=0.05,
        matters=0.01,
        note="equivalent slip angle per camber",
    )

    def motion(self, motion: Motion) -> None:
        camber = np.sin(motion.data.gamma)[:, None]
        motion.lateral += self.share * camber * motion.travel


@dataclass(frozen=True)
class PlySteer(TireEffect):
    """The belt steers: a lateral force at zero slip angle that turns with the direction of travel.

    Source: tire uniformity practice (ISO 8855 terms)
    """

    identifier = "ply_steer"
    title = "Ply steer"
    kind = "tire"
    coordinate = "slip level"
    source = "tire uniformity practice (ISO 8855 terms)"
    what = "The cords of the belt make the tire roll at an angle."
    check = "Reversed run: ply steer changes its sign, conicity does not."
    removes = "Nothing: it belongs to the tire."

    angle: float = param(0.0, unit="rad", bounds=(-0.02, 0.02), screen=1e-3, matters=5e-4)

    def motion(self, motion: Motion) -> None:
        motion.lateral += self.angle * motion.travel


@dataclass(frozen=True)
class Conicity(TireEffect):
    """The tire is a cone: a lateral force that grows with the load and does not change with the direction.

    Source: tire uniformity practice (ISO 8855 terms)
    """

    identifier = "conicity"
    title = "Conicity"
    kind = "tire"
    coordinate = "load"
    source = "tire uniformity practice (ISO 8855 terms)"
    what = "The belt sits off centre: the tire pulls to one side."
    check = "Turn the tire on the rim: conicity changes its sign."
    removes = "Nothing: it belongs to the tire."

    share: float = param(
        0.0,
        unit="1",
        bounds=(-0.05, 0.05),
        screen=0.003,
        matters=0.002,
        note="lateral force per load while rolling",
    )

    def signal(self, signal: Signal) -> None:
        data = signal.data
        signal.fy = signal.fy + self.share * data.load * (data.position > 0.0005)


@dataclass(frozen=True)
class CombinedSlip(TireEffect):
    """Longitudinal and lateral slip share the friction.

    Source: thesis 6.3: friction ellipse, figures 6.12 and 6.13
    """

    identifier = "combined_slip"
    title = "Combined slip"
    kind = "tire"
    coordinate = "slip level"
    source = "thesis 6.3: friction ellipse, figures 6.12 and 6.13"
    what = "Friction that is used in one direction is missing in the other."
    check = "Runs at 5 deg of side slip."
    removes = "Nothing: it belongs to the tire."

    share: float = param(
        0.0, unit="1", bounds=(0.0, 2.0), screen=0.3, matters=0.1, note="1: isotropic patch"
    )

    def tire(self, tire: Tire) -> None:
        tire.x.combine += self.per_run.share
        tire.y.combine += self.per_run.share
