# SPDX-License-Identifier: Apache-2.0
"""A share of the measured change of load never reaches the tire."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.contact_patch.parameters import LEAST_LOAD, moving_load
from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.effects.base import Tire, TireEffect


@dataclass(frozen=True)
class MeasuredLoad(TireEffect):
    """A share of the measured change of load never reaches the tire: the load is nearer to
    nominal.
    """

    identifier = "measured_load"
    title = "The measured load variation is not felt by the tire"
    kind = "sensor"
    coordinate = "load"
    source = "the base feeds the measured load to the tire"
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

    @classmethod
    def variants(cls, runs: RunSet, residual: np.ndarray) -> list[dict[str, float]]:
        """None where the load hardly moves: its last newtons are the noise of its channel."""
        load = runs.coordinates["load"].values
        return [{}] if moving_load(load) > LEAST_LOAD else []

    def tire(self, tire: Tire) -> None:
        tire.load -= self.share * (tire.load - tire.load.mean(axis=-1, keepdims=True))
