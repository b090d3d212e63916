# SPDX-License-Identifier: Apache-2.0
"""Part of the deflection comes late."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.effects.base import Tire, TireEffect


@dataclass(frozen=True)
class CarcassCreep(TireEffect):
    """Part of the deflection comes late: a spring and a damper in series with the carcass."""

    identifier = "carcass_creep"
    title = "Creep of the carcass"
    kind = "tire"
    coordinate = "time"
    law = True
    source = "the tire itself, not the thesis's machine"
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
