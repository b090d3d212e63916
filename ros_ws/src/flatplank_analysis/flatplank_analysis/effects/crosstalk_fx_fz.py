# SPDX-License-Identifier: Apache-2.0
"""A share of the longitudinal force appears in the load channel."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Signal, Tire, TireEffect


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
