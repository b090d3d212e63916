# SPDX-License-Identifier: Apache-2.0
"""Tires that are not alike when braking and when driving."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Tire, TireEffect


@dataclass(frozen=True)
class LessWhenBraking(TireEffect):
    """A number of the tire is smaller at negative slip."""

    kind = "tire"
    coordinate = "slip level"

    less: float = param(
        0.0,
        unit="1",
        bounds=(-0.4, 0.4),
        screen=0.04,
        matters=0.01,
        note="relative loss when braking",
    )


@dataclass(frozen=True)
class DriveBrakeAsymmetry(LessWhenBraking):
    """The friction differs between braking and driving."""

    identifier = "drive_brake_asymmetry"
    title = "Less friction when braking than when driving"
    source = "thesis 6.3: tires respond differently to drive and brake slip"
    what = (
        "The tire grips less in one direction; or the load falls when braking, unseen by the hub."
    )
    check = (
        "Turn the tire on the rim: the difference goes with the tire, or stays with the machine."
    )
    removes = "Nothing when it is the tire; a load control when it is the load."

    def tire(self, tire: Tire) -> None:
        tire.x.asym_peak += self.per_run.less


@dataclass(frozen=True)
class DriveBrakeStiffness(LessWhenBraking):
    """The slip stiffness differs between braking and driving."""

    identifier = "drive_brake_stiffness"
    title = "Less slip stiffness when braking than when driving"
    source = "thesis 7.1, figure 7.8"
    what = "The tire is softer in one direction."
    check = "Turn the tire on the rim: the difference goes with the tire."
    removes = "Nothing: it belongs to the tire."

    def tire(self, tire: Tire) -> None:
        tire.x.asym_stiff += self.per_run.less
