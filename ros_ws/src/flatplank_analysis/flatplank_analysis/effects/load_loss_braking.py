# SPDX-License-Identifier: Apache-2.0
"""The axle height is fixed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.effects.base import Signal, Tire, TireEffect


@dataclass(frozen=True)
class LoadLossBraking(TireEffect):
    """The axle height is fixed: braking takes load off the tire."""

    identifier = "load_loss_braking"
    title = "Load loss when braking"
    kind = "machine"
    rarity = 1
    coordinate = "slip level"
    source = "thesis table 6.3: -3.6 % of load at -10 % of slip"
    what = (
        "With a fixed axle height the braking torque turns the support and lifts the wheel a "
        "little."
    )
    check = "Read the load before and after a -10 % step; look at the loaded radius."
    removes = "Control the load instead of the height; or nothing, when the load is measured."
    main = "loss"

    loss: float = param(
        0.0,
        unit="1",
        bounds=(-0.05, 0.2),
        screen=0.02,
        matters=0.01,
        note="load lost per braking force",
    )
    seen: float = param(
        1.0, unit="1", bounds=(0.0, 1.0), note="1: the load channel shows it, 0: it does not"
    )

    @classmethod
    def variants(cls, runs: RunSet, residual: np.ndarray) -> list[dict[str, float]]:
        return [{"seen": 1.0}, {"seen": 0.0}] if "fz" in runs.channels else [{"seen": 0.0}]

    @classmethod
    def scanned(cls, runs: RunSet) -> int:
        return 2

    @classmethod
    def held(cls) -> tuple[str, ...]:
        return ("seen",)

    def tire(self, tire: Tire) -> None:
        tire.x.loss_brake += self.per_run.loss * (1.0 - self.per_run.seen)

    def signal(self, signal: Signal) -> None:
        # the measured load, loss included, is what the base feeds to the tire
        signal.fz = signal.fz + self.seen * self.loss * np.minimum(signal.true_fx, 0.0)
