# SPDX-License-Identifier: Apache-2.0
"""A share of the lateral force appears in the longitudinal force, whatever the slip."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.effects.base import Signal, TireEffect
from flatplank_analysis.effects.channels import other

LEAST = 100.0
"""[N] root mean square of the lateral force"""


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
        """None where there is hardly a lateral force: a fifth of it would pass for noise."""
        force = runs.measured[runs.channels.index("fy")] if "fy" in runs.channels else 0.0
        return [{"tared": 1.0}] if float(np.sqrt(np.mean(force**2))) > LEAST else []

    @classmethod
    def held(cls) -> tuple[str, ...]:
        return ("tared",)

    def signal(self, signal: Signal) -> None:
        signal.fx = signal.fx + self.share * other(signal.data, "fy", self.tared)
