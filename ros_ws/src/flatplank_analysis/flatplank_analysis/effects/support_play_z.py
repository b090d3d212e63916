# SPDX-License-Identifier: Apache-2.0
"""The axle drops or rises by its play when the longitudinal force changes sides."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Signal, TireEffect


@dataclass(frozen=True)
class SupportPlayZ(TireEffect):
    """The axle drops or rises by its play when the longitudinal force changes sides."""

    identifier = "support_play_z"
    title = "Play of the support in z"
    kind = "machine"
    coordinate = "slip level"
    source = "thesis 3.1: 1.3 mm in z"
    what = (
        "The support has play in z: the torque reaction moves the axle from one side to the "
        "other, and the load with it."
    )
    check = "Dial gauge at the axle during a change from braking to driving."
    removes = "New bearings of the rotation support."

    gap: float = param(
        0.0,
        unit="m",
        bounds=(-2e-3, 2e-3),
        screen=2e-4,
        matters=1e-4,
        note="change of axle height",
    )

    def signal(self, signal: Signal) -> None:
        # vertical stiffness of the tire, thesis Table 7.2
        side = np.tanh(signal.true_fx / 200.0)
        signal.fz = signal.fz + 0.5 * 2.13e5 * self.gap * side
