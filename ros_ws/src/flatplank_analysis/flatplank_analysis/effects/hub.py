# SPDX-License-Identifier: Apache-2.0
"""The measurement hub: crosstalk, gain, zero."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.effects.base import Signal, Tire, TireEffect

if TYPE_CHECKING:
    from flatplank_analysis.tirebase.data import TireRuns


def other(data: TireRuns, channel: str, tared: np.ndarray) -> np.ndarray:
    """Another measured channel (lanes, runs, samples), minus its value at the start when tared."""
    values = data.signals.get(channel)
    if values is None:
        return np.zeros((1, *data.position.shape)) * tared
    return values - tared * values[:, :5].mean(axis=1, keepdims=True)


@dataclass(frozen=True)
class CrosstalkFy(TireEffect):
    """A share of the lateral force appears in the longitudinal force, whatever the slip.

    Source: thesis 3.1 and Appendix A: the calibration matrix of the hub
    """

    identifier = "crosstalk_fy"
    title = "Crosstalk from the lateral force into Fx"
    kind = "sensor"
    coordinate = "time"
    source = "thesis 3.1 and Appendix A: the calibration matrix of the hub"
    what = "The bridge of Fx also answers to the lateral force."
    check = "Load the standing wheel in that direction only and read Fx."
    removes = "A full calibration matrix of the hub."
    main = "share"

    share: float = param(0.0, unit="1", bounds=(-0.5, 0.5), screen=0.05, matters=0.02)
    tared: float = param(
        0.0,
        unit="1",
        bounds=(0.0, 1.0),
        note="1: the channel was set to zero at the start of each run",
    )

    @classmethod
    def variants(cls, runs: RunSet, residual: np.ndarray) -> list[dict[str, float]]:
        return [{"tared": 1.0}]

    @classmethod
    def held(cls) -> tuple[str, ...]:
        return ("tared",)

    def signal(self, signal: Signal) -> None:
        signal.fx = signal.fx + self.share * other(signal.data, "fy", self.tared)


@dataclass(frozen=True)
class CrosstalkFz(TireEffect):
    """A share of the load appears in the longitudinal force, whatever the slip.

    Source: thesis 3.1 and Appendix A: the calibration matrix of the hub
    """

    identifier = "crosstalk_fz"
    title = "Crosstalk from the load into Fx"
    kind = "sensor"
    coordinate = "load"
    source = "thesis 3.1 and Appendix A: the calibration matrix of the hub"
    what = "The bridge of Fx also answers to the load."
    check = "Load the standing wheel in that direction only and read Fx."
    removes = "A full calibration matrix of the hub."
    main = "share"

    share: float = param(0.0, unit="1", bounds=(-0.3, 0.3), screen=0.02, matters=0.01)
    tared: float = param(
        0.0,
        unit="1",
        bounds=(0.0, 1.0),
        note="1: the channel was set to zero at the start of each run",
    )

    @classmethod
    def variants(cls, runs: RunSet, residual: np.ndarray) -> list[dict[str, float]]:
        return [{"tared": 1.0}, {"tared": 0.0}]

    @classmethod
    def held(cls) -> tuple[str, ...]:
        return ("tared",)

    def signal(self, signal: Signal) -> None:
        signal.fx = signal.fx + self.share * other(signal.data, "fz", self.tared)


@dataclass(frozen=True)
class CrosstalkMx(TireEffect):
    """A share of the overturning moment appears in the longitudinal force, whatever the slip.

    Source: thesis 3.1 and Appendix A: the calibration matrix of the hub
    """

    identifier = "crosstalk_mx"
    title = "Crosstalk from the overturning moment into Fx"
    kind = "sensor"
    coordinate = "time"
    source = "thesis 3.1 and Appendix A: the calibration matrix of the hub"
    what = "The bridge of Fx also answers to the overturning moment."
    check = "Load the standing wheel in that direction only and read Fx."
    removes = "A full calibration matrix of the hub."
    main = "share"

    share: float = param(0.0, unit="1/m", bounds=(-20.0, 20.0), screen=1.0, matters=0.5)
    tared: float = param(
        0.0,
        unit="1",
        bounds=(0.0, 1.0),
        note="1: the channel was set to zero at the start of each run",
    )

    @classmethod
    def variants(cls, runs: RunSet, residual: np.ndarray) -> list[dict[str, float]]:
        return [{"tared": 1.0}]

    @classmethod
    def held(cls) -> tuple[str, ...]:
        return ("tared",)

    def signal(self, signal: Signal) -> None:
        signal.fx = signal.fx + self.share * other(signal.data, "mx", self.tared)


@dataclass(frozen=True)
class CrosstalkMz(TireEffect):
    """A share of the aligning moment appears in the longitudinal force, whatever the slip.

    Source: thesis 3.1 and Appendix A: the calibration matrix of the hub
    """

    identifier = "crosstalk_mz"
    title = "Crosstalk from the aligning moment into Fx"
    kind = "sensor"
    coordinate = "time"
    source = "thesis 3.1 and Appendix A: the calibration matrix of the hub"
    what = "The bridge of Fx also answers to the aligning moment."
    check = "Load the standing wheel in that direction only and read Fx."
    removes = "A full calibration matrix of the hub."
    main = "share"

    share: float = param(0.0, unit="1/m", bounds=(-20.0, 20.0), screen=1.0, matters=0.5)
    tared: float = param(
        0.0,
        unit="1",
        bounds=(0.0, 1.0),
        note="1: the channel was set to zero at the start of each run",
    )

    @classmethod
    def variants(cls, runs: RunSet, residual: np.ndarray) -> list[dict[str, float]]:
        return [{"tared": 1.0}]

    @classmethod
    def held(cls) -> tuple[str, ...]:
        return ("tared",)

    def signal(self, signal: Signal) -> None:
        signal.fx = signal.fx + self.share * other(signal.data, "mz", self.tared)


@dataclass(frozen=True)
class CrosstalkFxFy(TireEffect):
    """A share of the longitudinal force appears in the lateral force.

    Source: thesis Appendix A: the calibration matrix of the hub
    """

    identifier = "crosstalk_fx_fy"
    title = "Crosstalk from Fx into Fy"
    kind = "sensor"
    coordinate = "slip level"
    source = "thesis Appendix A: the calibration matrix of the hub"
    what = "The bridge of Fy also answers to Fx, or the hub is turned about the vertical axis."
    check = "Pull the standing wheel in x only and read Fy."
    removes = "A full calibration matrix of the hub."

    share: float = param(0.0, unit="1", bounds=(-0.3, 0.3), screen=0.02, matters=0.005)

    def signal(self, signal: Signal) -> None:
        signal.fy = signal.fy + self.share * signal.true_fx


@dataclass(frozen=True)
class CrosstalkFxFz(TireEffect):
    """A share of the longitudinal force appears in the load channel.

    Source: thesis Appendix A: the calibration matrix of the hub
    """

    identifier = "crosstalk_fx_fz"
    title = "Crosstalk from Fx into Fz"
    kind = "sensor"
    coordinate = "slip level"
    source = "thesis Appendix A: the calibration matrix of the hub"
    what = "The bridges of Fz also answer to Fx."
    check = "Pull the standing wheel in x only and read Fz."
    removes = "A full calibration matrix of the hub."

    share: float = param(0.0, unit="1", bounds=(-0.3, 0.3), screen=0.02, matters=0.01)

    def tire(self, tire: Tire) -> None:
        tire.x.loss_brake -= self.per_run.share
        tire.x.loss_drive -= self.per_run.share

    def signal(self, signal: Signal) -> None:
        signal.fz = signal.fz + self.share * signal.true_fx


@dataclass(frozen=True)
class HubGain(TireEffect):
    """The longitudinal force is read too large by a factor.

    Source: thesis Appendix A
    """

    identifier = "hub_gain"
    title = "Gain of the Fx channel"
    kind = "sensor"
    coordinate = "slip level"
    source = "thesis Appendix A"
    what = (
        "A wrong calibration factor of Fx. A fitted tire hides it: only a weight on a rope "
        "shows it."
    )
    check = "Pull the standing wheel with a known force."
    removes = "Recalibrate Fx."

    gain: float = param(0.0, unit="1", bounds=(-0.3, 0.3), screen=0.02, matters=0.01)

    def signal(self, signal: Signal) -> None:
        signal.fx = signal.fx * (1.0 + self.gain)


@dataclass(frozen=True)
class ZeroDrift(TireEffect):
    """The zero of Fx creeps with time during every run.

    Source: thesis 3.1: warming-up of the bridge amplifiers
    """

    identifier = "zero_drift"
    title = "Drift of the zero during a run"
    kind = "sensor"
    coordinate = "time"
    source = "thesis 3.1: warming-up of the bridge amplifiers"
    what = "The bridge amplifier warms up: the zero creeps during the run."
    check = "Record the standing wheel for five minutes."
    removes = "Let the amplifier warm up; tare before each run."

    drift: float = param(0.0, unit="N/s", bounds=(-3.0, 3.0), screen=0.1, matters=0.04)

    def signal(self, signal: Signal) -> None:
        signal.fx = signal.fx + self.drift * signal.data.runs.time


@dataclass(frozen=True)
class ZeroDriftRuns(TireEffect):
    """The zero of Fx creeps from run to run.

    Source: thesis 3.1
    """

    identifier = "zero_drift_runs"
    title = "Drift of the zero over the runs"
    kind = "sensor"
    coordinate = "run order"
    source = "thesis 3.1"
    what = "The zero of the bridge creeps during the campaign."
    check = "Compare the readings at standstill before each run."
    removes = "Tare before each run."

    drift: float = param(
        0.0,
        unit="N",
        bounds=(-300.0, 300.0),
        screen=20.0,
        matters=5.0,
        note="from the first to the last run",
    )

    def signal(self, signal: Signal) -> None:
        order = signal.data.runs.order
        share = (order - order.mean()) / max(float(np.ptp(order)), 1.0)
        signal.fx = signal.fx + self.drift * share[:, None]


@dataclass(frozen=True)
class ZeroOffset(TireEffect):
    """The longitudinal force is not zero at standstill.

    Source: thesis Appendix A
    """

    identifier = "zero_offset"
    title = "Zero error of Fx"
    kind = "sensor"
    coordinate = "time"
    source = "thesis Appendix A"
    what = "The bridge was not set to zero, or the standing tire is strained."
    check = "Read Fx with the wheel lifted."
    removes = "Tare with the wheel lifted."

    zero: float = param(0.0, unit="N", bounds=(-300.0, 300.0), screen=10.0, matters=5.0)

    def signal(self, signal: Signal) -> None:
        signal.fx = signal.fx + self.zero
