# SPDX-License-Identifier: Apache-2.0
"""Load cells that show something else than the force."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.slip_sweeps.effects.base import SweepEffect, above


@dataclass(frozen=True)
class LoadGain(SweepEffect):
    """Shown load over true load, less one.

    Source: definition of a gain.
    """

    identifier = "load_gain"
    title = "load cell of Fz shows a share too much"
    kind = "sensor"
    coordinate = "fz"
    needs = ("fz",)
    what = "the tire carries another load than the file of the bench says"
    check = "hang a known weight, or compare with a scale"
    removes = "calibrate the load cell of Fz"
    gain: float = param(0.0, unit="1", bounds=(-0.3, 0.3), screen=0.01, matters=0.003)

    def tire(self, s: Any) -> None:
        s.fz = s.fz / (1.0 + self.gain)


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
    rate: float = param(0.0, unit="N/s", bounds=(-5.0, 5.0), screen=0.02, matters=0.005)

    def bench(self, s: Any) -> None:
        s.force = s.force + self.rate * above(s.time)


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
    what = "a load cell that is turned shows a part of the load"
    check = "load the standing wheel on a free plate: only Fz may change"
    removes = "calibrate the crosstalk of the hub"
    share: float = param(0.0, unit="1", bounds=(-0.2, 0.2), screen=0.005, matters=0.001)

    def bench(self, s: Any) -> None:
        s.force = s.force + self.share * (s.fz - s.nominal.FNOMIN)
