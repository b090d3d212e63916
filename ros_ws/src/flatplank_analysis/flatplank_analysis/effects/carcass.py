# SPDX-License-Identifier: Apache-2.0
"""Deflection of the carcass: creep, and stiffness that depends on load, pressure and force."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from flatplank_analysis.contact_patch.size import contact_ratio, usual_load_of
from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.effects.base import Tire, TireProperty, several_speeds

TRANSIENT = 0.1
"""[m] relaxation length of the usual tire along the wheel: at one speed a creep on a shorter way
cannot be told from the transient of the tire"""


@dataclass(frozen=True)
class CarcassCreep(TireProperty):
    """Part of the deflection is delayed: a spring and a damper in series with the carcass."""

    identifier = "carcass_creep"
    title = "Creep of the carcass"
    coordinate = "time"
    law = True
    source = "the tire itself, not the thesis's machine"
    what = "Rubber creeps: the deflection goes on under a constant force."
    check = "Hold the standing tire under a force."
    shown_by = "The same run at 0.0015 m/s."

    share: float = param(
        0.0, unit="1", bounds=(0.0, 2.0), screen=0.1, matters=0.05,
        title="share of the creep", symbol="c_cr",
        note="Late deflection over the prompt one under a constant force.",
    )  # fmt: skip
    time: float = param(
        10.0, unit="s", bounds=(1.0, 60.0),
        title="time of the creep", symbol="τ_cr", note="Time constant of the late deflection.",
    )  # fmt: skip

    @classmethod
    def variants(cls, runs: RunSet, residual: np.ndarray) -> list[dict[str, float]]:
        return [{"time": t} for t in (4.0, 15.0)]

    @classmethod
    def separable(cls, runs: RunSet, values: Mapping[str, float] | None = None) -> bool:
        if values is None or several_speeds(runs):
            return True
        travel = values["time"] * runs.facts["speed"].max()
        return bool(travel > TRANSIENT * contact_ratio(usual_load_of(runs)))

    def tire(self, tire: Tire) -> None:
        tire.x.creep += self.per_run.share
        tire.x.creep_time = self.per_run.time


@dataclass(frozen=True)
class CarcassLoad(TireProperty):
    """The carcass gets stiffer or softer with the nominal load."""

    identifier = "carcass_load"
    title = "Carcass stiffness depends on the load"
    coordinate = "load"
    source = "thesis figure 7.24"
    what = (
        "The relaxation length grows otherwise with the load than the slip stiffness alone "
        "would make it."
    )
    check = "Stiffness test of the standing tire at three loads."
    shown_by = "Runs at three loads."

    slope: float = param(
        0.0, unit="1", bounds=(-1.0, 2.0), screen=0.2, matters=0.05,
        title="carcass stiffness over load", symbol="q_cF",
        note="Relative change of the carcass stiffness over that of the load.",
    )  # fmt: skip
    bend: float = param(
        0.0, unit="1", bounds=(-0.6, 0.6), prior=0.3,
        title="carcass stiffness over load squared", symbol="q_cFF",
        note="Relative change of the carcass stiffness over the square of that of the load.",
    )  # fmt: skip

    def tire(self, tire: Tire) -> None:
        more = tire.data.relative_load - 1.0
        change = 1.0 + self.per_run.slope * more + self.per_run.bend * more**2
        change = np.maximum(change, 0.1)
        tire.x.carcass *= change
        tire.y.carcass *= change


@dataclass(frozen=True)
class CarcassPressure(TireProperty):
    """The carcass gets stiffer with the pressure."""

    identifier = "carcass_pressure"
    title = "Carcass stiffness depends on the pressure"
    coordinate = "slip level"
    source = "thesis figure 7.24"
    what = "A soft tire has a soft carcass."
    check = "Stiffness test of the standing tire at two pressures."
    shown_by = "Runs at two pressures."

    slope: float = param(
        0.0, unit="1", bounds=(-1.0, 3.0), screen=0.2, matters=0.05,
        title="carcass stiffness over pressure", symbol="q_cp",
        note="Relative change of the carcass stiffness over that of the pressure.",
    )  # fmt: skip

    def tire(self, tire: Tire) -> None:
        data = tire.data
        change = 1.0 + self.per_run.slope * (data.relative_pressure - 1.0)
        tire.x.carcass *= change
        tire.y.carcass *= change


@dataclass(frozen=True)
class CarcassSoftening(TireProperty):
    """The deflection of the carcass grows faster than the force."""

    identifier = "carcass_softening"
    title = "The carcass softens with the force"
    coordinate = "distance since the step"
    law = True
    source = "the tire itself, not the thesis's machine"
    what = "A carcass is not a straight spring: large forces deflect it more."
    check = "Stiffness test of the standing tire to large forces."

    soften: float = param(
        0.0, unit="1", bounds=(-0.4, 2.0), screen=0.1, matters=0.05,
        title="softening of the carcass", symbol="q_cx",
        note="Relative compliance that the carcass has gained at a force of 4 kN.",
    )  # fmt: skip

    def tire(self, tire: Tire) -> None:
        tire.x.soften += self.per_run.soften
