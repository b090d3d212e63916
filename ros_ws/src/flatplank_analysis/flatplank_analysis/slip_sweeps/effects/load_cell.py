# SPDX-License-Identifier: Apache-2.0
"""Load cells that show something else than the force."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.sweep_base import SweepEffect


@dataclass(frozen=True)
class ZeroDrift(SweepEffect):
    """A force that grows with time.

    Source: definition of a drift.
    """

    identifier = "zero_drift"
    title = "zero of the force drifts with time"
    kind = "sensor"
    coordinate = "time"
    needs = ("time",)
    what = "the zero of a warming load cell creeps"
    check = "record the unloaded wheel before and after"
    removes = "tare before each sweep"
    rate: float = param(
        0.0, unit="N/s", bounds=(-5.0, 5.0), screen=0.02, matters=0.005,
        title="drift of the zero", symbol="dF_0",
        note="Change of the zero of the force in a second.",
    )  # fmt: skip

    def bench(self, s: Any) -> None:
        s.force = s.force + self.rate * s.above("time")


@dataclass(frozen=True)
class Crosstalk(SweepEffect):
    """A share of the load beyond the nominal one.

    Source: definition of a crosstalk.
    """

    identifier = "crosstalk"
    title = "the load shows in the other force"
    kind = "sensor"
    coordinate = "fz"
    needs = ("fz",)
    in_file = True
    what = "a load cell that is turned shows a part of the load"
    check = "load the standing wheel on a free plate: only Fz may change"
    removes = "calibrate the crosstalk of the hub"
    share: float = param(
        0.0, unit="1", bounds=(-0.2, 0.2), screen=0.005, matters=0.001,
        title="crosstalk of the load", symbol="c_z",
        note="Reading of the force over the load beyond the nominal one.",
    )  # fmt: skip

    def bench(self, s: Any) -> None:
        s.force = s.force + self.share * (s.fz - s.nominal.FNOMIN)
