# SPDX-License-Identifier: Apache-2.0
"""A share of the aligning moment appears in the longitudinal force, whatever the slip."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.effects.base import Signal, TireEffect
from flatplank_analysis.effects.channels import other


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
