# SPDX-License-Identifier: Apache-2.0
"""The force law of the tire."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Signal, Tire, TireEffect


LEVELS = (
    "brake_10", "brake_5", "brake_2", "brake_1", "drive_1", "drive_2", "drive_5", "drive_10",
)  # fmt: skip


@dataclass(frozen=True)
class DriveBrakeAsymmetry(TireEffect):
    """The friction differs between braking and driving.

    Source: thesis 6.3: tires respond differently to drive and brake slip
    """

    identifier = "drive_brake_asymmetry"
    title = "Less friction when braking than when driving"
    kind = "tire"
    coordinate = "slip level"
    source = "thesis 6.3: tires respond differently to drive and brake slip"
    what = (
        "The tire grips less in one direction; or the load falls when braking, unseen by the hub."
    )
    check = (
        "Turn the tire on the rim: the difference goes with the tire, or stays with the machine."
    )
    removes = "Nothing when it is the tire; a load control when it is the load."

    less: float = param(
        0.0,
        unit="1",
        bounds=(-0.4, 0.4),
        screen=0.04,
        matters=0.01,
        note="relative loss of friction when braking",
    )

    def tire(self, tire: Tire) -> None:
        tire.x.asym_peak += self.per_run.less


@dataclass(frozen=True)
class DriveBrakeStiffness(TireEffect):
    """The slip stiffness differs between braking and driving.

    Source: thesis 7.1, figure 7.8
    """

    identifier = "drive_brake_stiffness"
    title = "Less slip stiffness when braking than when driving"
    kind = "tire"
    coordinate = "slip level"
    source = "thesis 7.1, figure 7.8"
    what = "The tire is softer in one direction."
    check = "Turn the tire on the rim: the difference goes with the tire."
    removes = "Nothing: it belongs to the tire."

    less: float = param(
        0.0,
        unit="1",
        bounds=(-0.4, 0.4),
        screen=0.04,
        matters=0.01,
        note="relative loss of slip stiffness when braking",
    )

    def tire(self, tire: Tire) -> None:
        tire.x.asym_stiff += self.per_run.less


@dataclass(frozen=True)
class SlipDefinition(TireEffect):
    """Slip over the travel of the road or over the rolled distance.

    Source: DISCOVERY 1; the base has it as its parameter denom
    """

    identifier = "slip_definition"
    title = "Definition of the slip"
    kind = "tire"
    coordinate = "slip level"
    source = "DISCOVERY 1; the base has it as its parameter denom"
    what = "Theoretical slip kappa/(1 + kappa) or practical slip kappa: a choice of the model."
    check = "Nothing to check on the machine."
    removes = "The base fits it already."

    more: float = param(0.0, unit="1", bounds=(-1.5, 1.5), screen=0.3, matters=0.2)

    def tire(self, tire: Tire) -> None:
        tire.x.denom += self.per_run.more


@dataclass(frozen=True)
class RollingResistance(TireEffect):
    """A braking force in proportion to the load while the tire rolls.

    Source: thesis 6.3: small negative force at free rolling
    """

    identifier = "rolling_resistance"
    title = "Rolling resistance"
    kind = "tire"
    coordinate = "load"
    source = "thesis 6.3: small negative force at free rolling"
    what = (
        "The rolling tire resists. The base fits a constant force while rolling already; runs "
        "at other loads show the difference."
    )
    check = "Free-rolling runs at three loads."
    removes = "Nothing: it belongs to the tire."

    share: float = param(0.0, unit="1", bounds=(-0.05, 0.05), screen=0.005, matters=0.002)

    def signal(self, signal: Signal) -> None:
        data = signal.data
        rolling = 1.0 - np.exp(-np.maximum(data.position, 0.0) / 0.005)
        signal.fx = signal.fx - self.share * data.load * rolling


@dataclass(frozen=True)
class FreeLaw(TireEffect):
    """A free correction of the steady force over the contact slip, driving and braking apart.

    Source: thesis 7.2: look-up table of the steady force; DISCOVERY 1
    """

    identifier = "tire_law"
    title = "The force law is of another form"
    generic = True
    kind = "tire"
    coordinate = "slip level"
    source = "thesis 7.2: look-up table of the steady force; DISCOVERY 1"
    what = (
        "The machine is fine; the symmetric force law of the base is not the law of this "
        "tire. A table of the steady force may swallow a drive/brake asymmetry, so it is the "
        "last name to be given."
    )
    check = "Nothing to check on the machine."
    removes = "A table of the steady force, or another law."

    brake_10: float = param(0.0, unit="1", bounds=(-0.4, 0.4), screen=0.02, matters=0.01)
    brake_5: float = param(0.0, unit="1", bounds=(-0.4, 0.4), screen=0.02)
    brake_2: float = param(0.0, unit="1", bounds=(-0.4, 0.4), screen=0.02)
    brake_1: float = param(0.0, unit="1", bounds=(-0.4, 0.4), screen=0.02)
    drive_1: float = param(0.0, unit="1", bounds=(-0.4, 0.4), screen=0.02)
    drive_2: float = param(0.0, unit="1", bounds=(-0.4, 0.4), screen=0.02)
    drive_5: float = param(0.0, unit="1", bounds=(-0.4, 0.4), screen=0.02)
    drive_10: float = param(0.0, unit="1", bounds=(-0.4, 0.4), screen=0.02)

    @classmethod
    def size(cls, values: dict[str, float]) -> float:
        return max(values.values(), key=abs)

    def tire(self, tire: Tire) -> None:
        for i, name in enumerate(LEVELS):
            block = f"law_{i}"
            setattr(tire.x, block, getattr(tire.x, block) + getattr(self.per_run, name))
