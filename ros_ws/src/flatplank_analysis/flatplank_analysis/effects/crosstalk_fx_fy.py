# SPDX-License-Identifier: Apache-2.0
"""A share of the longitudinal force appears in the lateral force."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Signal, TireEffect


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
