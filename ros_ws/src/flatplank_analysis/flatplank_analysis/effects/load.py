# SPDX-License-Identifier: Apache-2.0
"""Load on the tire other than the measured one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.effects.base import Signal, Tire, TireEffect
from flatplank_analysis.effects.waves import periods


@dataclass(frozen=True)
class MeasuredLoad(TireEffect):
    """A share of the measured change of load never reaches the tire: the load is nearer to nominal.

    Source: DISCOVERY 1: the base feeds the measured load to the tire
    """

    identifier = "measured_load"
    title = "The measured load variation is not felt by the tire"
    kind = "sensor"
    coordinate = "load"
    source = "DISCOVERY 1: the base feeds the measured load to the tire"
    what = (
        "The load channel shows changes that the tire does not feel (crosstalk, bending of "
        "the hub)."
    )
    check = "Weigh the wheel on a scale while the hub reads; compare the sum of the forces."
    removes = "Recalibrate the load channel."

    share: float = param(
        0.0,
        unit="1",
        bounds=(-1.0, 2.0),
        screen=0.5,
        matters=0.3,
        note="share of the measured change that is not there",
    )

    def tire(self, tire: Tire) -> None:
        tire.load -= self.share * (tire.load - tire.load.mean(axis=-1, keepdims=True))


@dataclass(frozen=True)
class LoadLossBraking(TireEffect):
    """The axle height is fixed: braking takes load off the tire.

    Source: thesis table 6.3: -3.6 % of load at -10 % of slip
    """

    identifier = "load_loss_braking"
    title = "Load loss when braking"
    kind = "machine"
    coordinate = "slip level"
    source = "thesis table 6.3: -3.6 % of load at -10 % of slip"
    what = (
        "With a fixed axle height the braking torque turns the support and lifts the wheel a "
        "little."
    )
    check = "Read the load before and after a -10 % step; look at the loaded radius."
    removes = "Control the load instead of the height; or nothing, when the load is measured."

    loss: float = param(
        0.0,
        unit="1",
        bounds=(-0.05, 0.2),
        screen=0.02,
        matters=0.01,
        note="load lost per braking force",
    )

    def tire(self, tire: Tire) -> None:
        if "fz" not in tire.data.runs.channels:
            tire.x.loss_brake += self.per_run.loss

    def signal(self, signal: Signal) -> None:
        # the measured load, loss included, is what the base feeds to the tire
        signal.fz = signal.fz + self.loss * np.minimum(signal.true_fx, 0.0)


@dataclass(frozen=True)
class LoadUndulation(TireEffect):
    """The plank is not level: the load on the tire waves with the plank position.

    Source: thesis 6.3, figure 6.6: support bearings and plank undulation
    """

    identifier = "load_undulation"
    title = "Load undulation over the plank that the hub does not see"
    kind = "machine"
    coordinate = "plank position"
    source = "thesis 6.3, figure 6.6: support bearings and plank undulation"
    what = "Bearings and bending of the plank change the load at fixed plank positions."
    check = "Dial gauge along the plank; reverse the direction: the places stay."
    removes = "Level the plank; measure the load at the contact."

    cos: float = param(0.0, unit="1", bounds=(-0.2, 0.2), screen=0.02, matters=0.005)
    sin: float = param(0.0, unit="1", bounds=(-0.2, 0.2), screen=0.02, matters=0.005)
    period: float = param(0.5, unit="m", bounds=(0.08, 2.5), note="in plank travel")

    @classmethod
    def variants(cls, runs: RunSet, residual: np.ndarray) -> list[dict[str, float]]:
        found = periods(runs, residual, 0.08, 2.5)
        return [{"period": p} for p in [*found, 0.35, 0.7, 1.4]]

    @classmethod
    def scanned(cls, runs: RunSet) -> int:
        return 100

    @classmethod
    def size(cls, values: dict[str, float]) -> float:
        return float(np.hypot(values["cos"], values["sin"]))

    def tire(self, tire: Tire) -> None:
        phase = 2.0 * np.pi * tire.data.position / self.period
        tire.load *= 1.0 + self.cos * np.cos(phase) + self.sin * np.sin(phase)
