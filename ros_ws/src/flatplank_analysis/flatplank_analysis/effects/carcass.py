# SPDX-License-Identifier: Apache-2.0
"""Carcass: dependence on load and pressure, softening, creep."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.effects.base import Tire, TireEffect


@dataclass(frozen=True)
class CarcassLoad(TireEffect):
    """The carcass gets stiffer or softer with the nominal load.

    Source: thesis figure 7.24
    """

    identifier = "carcass_load"
    title = "Carcass stiffness depends on the load"
    kind = "tire"
    coordinate = "load"
    source = "thesis figure 7.24"
    what = (
        "The relaxation length grows otherwise with the load than the slip stiffness alone "
        "would make it."
    )
    check = "Runs at three loads."
    removes = "Nothing: it belongs to the tire."

    slope: float = param(
        0.0,
        unit="1",
        bounds=(-1.0, 2.0),
        screen=0.2,
        matters=0.05,
        note="relative change per relative change of load",
    )

    def tire(self, tire: Tire) -> None:
        load = tire.data.nominal
        change = 1.0 + self.per_run.slope * (load / np.median(load) - 1.0)
        tire.x.carcass *= change
        tire.y.carcass *= change


@dataclass(frozen=True)
class CarcassPressure(TireEffect):
    """The carcass gets stiffer with the pressure.

    Source: thesis figure 7.24
    """

    identifier = "carcass_pressure"
    title = "Carcass stiffness depends on the pressure"
    kind = "tire"
    coordinate = "slip level"
    source = "thesis figure 7.24"
    what = "A soft tire has a soft carcass."
    check = "Runs at two pressures."
    removes = "Nothing: it belongs to the tire."

    slope: float = param(
        0.0,
        unit="1",
        bounds=(-1.0, 3.0),
        screen=0.2,
        matters=0.05,
        note="relative change per relative change of pressure",
    )

    def tire(self, tire: Tire) -> None:
        pressure = tire.data.pressure
        change = 1.0 + self.per_run.slope * (pressure / np.median(pressure) - 1.0)
        tire.x.carcass *= change
        tire.y.carcass *= change


@dataclass(frozen=True)
class CarcassSoftening(TireEffect):
    """The deflection of the carcass grows faster than the force.

    Source: REFERENCE 6, the tire itself
    """

    identifier = "carcass_softening"
    title = "The carcass softens with the force"
    kind = "tire"
    coordinate = "distance since the step"
    source = "REFERENCE 6, the tire itself"
    what = "A carcass is not a straight spring: large forces deflect it more."
    check = "Stiffness test of the standing tire to large forces."
    removes = "Nothing: it belongs to the tire."

    soften: float = param(
        0.0,
        unit="1",
        bounds=(-0.4, 2.0),
        screen=0.1,
        matters=0.05,
        note="relative compliance added at 4 kN",
    )

    def tire(self, tire: Tire) -> None:
        tire.x.soften += self.per_run.soften


@dataclass(frozen=True)
class CarcassCreep(TireEffect):
    """Part of the deflection comes late: a spring and a damper in series with the carcass.

    Source: REFERENCE 6, the tire itself
    """

    identifier = "carcass_creep"
    title = "Creep of the carcass"
    kind = "tire"
    coordinate = "time"
    source = "REFERENCE 6, the tire itself"
    what = "Rubber creeps: the deflection goes on under a constant force."
    check = "The same run at 0.0015 m/s; hold the standing tire under a force."
    removes = "Nothing: it belongs to the tire."
    main = "share"

    share: float = param(
        0.0,
        unit="1",
        bounds=(-0.2, 2.0),
        screen=0.1,
        matters=0.05,
        note="late deflection over prompt deflection",
    )
    time: float = param(10.0, unit="s", bounds=(1.0, 60.0), note="time constant")

    @classmethod
    def variants(cls, runs: RunSet, residual: np.ndarray) -> list[dict[str, float]]:
        return [{"time": t} for t in (4.0, 15.0)]

    def tire(self, tire: Tire) -> None:
        tire.x.creep += self.per_run.share
        tire.x.creep_time = self.per_run.time
