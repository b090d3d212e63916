# SPDX-License-Identifier: Apache-2.0
"""The steady force over the slip: its form, its two directions, its friction."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.effects.base import Tire, TireEffect, TireProperty, several_speeds

LEVELS = ("at_1", "at_2", "at_5", "at_10")


@dataclass(frozen=True)
class FreeLaw(TireEffect):
    """A free correction of the steady force over the size of the contact slip."""

    identifier = "tire_law"
    title = "The force law is of another form"
    kind = "tire"
    coordinate = "slip level"
    generic = True
    law = True
    source = "thesis 7.2: look-up table of the steady force"
    what = (
        "The machine is in order; the force over the slip has another form than in the base, "
        "alike in driving and braking. What differs between the two is an effect of its own. A "
        "table of the steady force explains much, so it is the last name to be given."
    )
    check = "Nothing to check on the machine."
    removes = "A table of the steady force, or another law."

    at_1: float = param(
        0.0, unit="1", bounds=(-0.4, 0.4), screen=0.02, matters=0.01,
        title="law at 1 %", symbol="q_1",
        note="Relative change of the steady force at a contact slip of 1 %.",
    )  # fmt: skip
    at_2: float = param(
        0.0, unit="1", bounds=(-0.4, 0.4), screen=0.02,
        title="law at 2 %", symbol="q_2",
        note="Relative change of the steady force at a contact slip of 2 %.",
    )  # fmt: skip
    at_5: float = param(
        0.0, unit="1", bounds=(-0.4, 0.4), screen=0.02,
        title="law at 5 %", symbol="q_5",
        note="Relative change of the steady force at a contact slip of 5 %.",
    )  # fmt: skip
    at_10: float = param(
        0.0, unit="1", bounds=(-0.4, 0.4), screen=0.02,
        title="law at 10 %", symbol="q_10",
        note="Relative change of the steady force at a contact slip of 10 %.",
    )  # fmt: skip

    @classmethod
    def size(cls, values: dict[str, float]) -> float:
        return max(values.values(), key=abs)

    def tire(self, tire: Tire) -> None:
        for i, name in enumerate(LEVELS):
            block = f"law_{i}"
            setattr(tire.x, block, getattr(tire.x, block) + getattr(self.per_run, name))


@dataclass(frozen=True)
class SlipDefinition(TireEffect):
    """Slip relative to the travel of the road or to the rolled distance."""

    identifier = "slip_definition"
    title = "Definition of the slip"
    kind = "tire"
    coordinate = "slip level"
    source = "the base has it as its parameter denom"
    what = "Theoretical slip kappa/(1 + kappa) or practical slip kappa: a choice of the model."
    check = "Nothing to check on the machine."
    removes = "The base fits it already."

    more: float = param(
        0.0, unit="1", bounds=(-1.5, 1.5), screen=0.3, matters=0.2,
        title="change of the definition of slip", symbol="q_d",
        note="Change of the number `denom` of the base.",
    )  # fmt: skip

    def tire(self, tire: Tire) -> None:
        tire.x.denom += self.per_run.more


@dataclass(frozen=True)
class SlidingFriction(TireEffect):
    """The friction depends on the sliding speed of the rubber."""

    identifier = "sliding_friction"
    title = "Friction falls with the sliding speed"
    kind = "tire"
    coordinate = "slip level"
    source = "thesis 2.3; with one plank speed it cannot be told from the force law"
    what = "Rubber loses (or gains) grip with the sliding speed."
    check = "Nothing to check on the machine."
    shown_by = "The same slips at 0.0015 m/s; runs at one speed do not name it."
    removes = "Nothing: it belongs to the tire; the law needs it when the speed changes."

    drop: float = param(
        0.0, unit="1", bounds=(-0.5, 0.9), screen=0.05, matters=0.02,
        title="loss of friction by sliding", symbol="q_v",
        note="Relative loss of friction at a sliding speed far above 1.5 mm/s.",
    )  # fmt: skip

    @classmethod
    def separable(cls, runs: RunSet, values: Mapping[str, float] | None = None) -> bool:
        return several_speeds(runs)

    def tire(self, tire: Tire) -> None:
        tire.x.slide += self.per_run.drop


@dataclass(frozen=True)
class CombinedSlip(TireProperty):
    """Longitudinal and lateral slip share the friction."""

    identifier = "combined_slip"
    title = "Combined slip"
    coordinate = "slip level"
    source = "thesis 6.3: friction ellipse, figures 6.12 and 6.13"
    what = "Friction that is used in one direction is missing in the other."
    check = "Nothing to check on the machine."
    shown_by = "Runs at 5 deg of side slip."

    share: float = param(
        0.0, unit="1", bounds=(0.0, 2.0), screen=0.3, matters=0.1,
        title="interaction of the slips", symbol="λ_xy",
        note="Share of the slip of one direction that counts in the other; 1: the patch is alike "
             "in all directions.",
    )  # fmt: skip

    def tire(self, tire: Tire) -> None:
        tire.x.other_slip += self.per_run.share
        tire.y.other_slip += self.per_run.share


@dataclass(frozen=True)
class LessWhenBraking(TireEffect):
    """A tire parameter is smaller at negative slip."""

    kind = "tire"
    coordinate = "slip level"

    less: float = param(
        0.0, unit="1", bounds=(-0.4, 0.4), screen=0.04, matters=0.01,
        title="loss in braking", symbol="q_b", note="Relative loss in braking, beside driving.",
    )  # fmt: skip


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
