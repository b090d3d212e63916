# SPDX-License-Identifier: Apache-2.0
"""Load on the tire: loss in braking, wrong readings; rolling resistance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.contact_patch.parameters import LEAST_LOAD, moving_load
from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.effects.base import Signal, Tire, TireEffect, TireProperty


@dataclass(frozen=True)
class LoadLossBraking(TireEffect):
    """The axle height is fixed: braking unloads the tire."""

    identifier = "load_loss_braking"
    title = "Load loss when braking"
    rarity = 1
    coordinate = "slip level"
    source = "thesis table 6.3: -3.6 % of load at -10 % of slip"
    what = (
        "With a fixed axle height the braking torque turns the support and lifts the wheel a "
        "little."
    )
    check = "Read the load before and after a -10 % step; look at the loaded radius."
    removes = "Control the load instead of the height; or nothing, when the load is measured."

    loss: float = param(
        0.0, unit="1", bounds=(-0.05, 0.2), screen=0.02, matters=0.01,
        title="loss of load", symbol="q_F", note="Load that is lost over the braking force.",
    )  # fmt: skip
    seen: float = param(
        1.0, unit="-", bounds=(0.0, 1.0),
        title="seen by the hub", symbol="b_s",
        note="1: the load channel shows the loss; 0: it does not.",
    )  # fmt: skip

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
        # the base applies the measured load, loss included, to the tire
        signal.fz = signal.fz + self.seen * self.loss * np.minimum(signal.true_fx, 0.0)


@dataclass(frozen=True)
class MeasuredLoad(TireEffect):
    """A share of the measured change of load does not act on the tire: the real load is closer to
    nominal."""

    identifier = "measured_load"
    title = "The measured load variation does not act on the tire"
    kind = "sensor"
    coordinate = "load"
    source = "the base feeds the measured load to the tire"
    what = (
        "The load channel shows changes that do not act on the tire (crosstalk, bending of "
        "the hub)."
    )
    check = "Weigh the wheel on a scale while the hub reads; compare the sum of the forces."
    removes = "Recalibrate the load channel."

    share: float = param(
        0.0, unit="1", bounds=(-1.0, 2.0), screen=0.5, matters=0.3,
        title="share that does not act", symbol="q_m",
        note="Share of the measured change of the load that is not there.",
    )  # fmt: skip

    @classmethod
    def variants(cls, runs: RunSet, residual: np.ndarray) -> list[dict[str, float]]:
        """No variant where the load hardly varies: the rest is noise of its channel."""
        load = runs.coordinates["load"].values
        return [{}] if moving_load(load) > LEAST_LOAD else []

    def tire(self, tire: Tire) -> None:
        tire.load -= self.share * (tire.load - tire.load.mean(axis=-1, keepdims=True))


@dataclass(frozen=True)
class RollingResistance(TireProperty):
    """A braking force proportional to the load while the tire rolls."""

    identifier = "rolling_resistance"
    title = "Rolling resistance"
    coordinate = "load"
    source = "thesis 6.3: small negative force at free rolling"
    what = (
        "The rolling tire resists. The base fits a constant force while rolling already; runs "
        "at other loads show the difference."
    )
    check = "Nothing to check on the machine."
    shown_by = "Free-rolling runs at three loads."

    share: float = param(
        0.0, unit="1", bounds=(-0.05, 0.05), screen=0.005, matters=0.002,
        title="rolling resistance", symbol="f_r",
        note="Braking force of the rolling tire over the load, beside the constant one of the "
             "base.",
    )  # fmt: skip

    def signal(self, signal: Signal) -> None:
        data = signal.data
        rolling = 1.0 - np.exp(-np.maximum(data.position, 0.0) / 0.005)
        signal.fx = signal.fx - self.share * data.load * rolling
