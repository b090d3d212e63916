# SPDX-License-Identifier: Apache-2.0
"""Speed of the steering motor from the angle of the hub itself: the gap of the worm is crossed
when the tire pulls."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_hw.params import Params, param


@dataclass(frozen=True)
class HoldParameters(Params):
    """Needs an encoder on the hub: the one on the worm does not see the play (thesis 3.1, 10)."""

    enabled: bool = param(False, "hold the hub's angle instead of the motor's")
    gain: float = param(6.0, "speed over angle error", unit="1/s", bounds=(0.1, 100.0))
    dead_band: float = param(
        3.5e-4, "an error that is left alone: 0.02 deg", unit="rad", bounds=(0.0, 0.1)
    )
    speed_limit: float = param(0.035, "2 deg/s", unit="rad/s", bounds=(1e-4, 1.0))


class SteeringHold:
    """`step` gives the speed of the steering axis [rad/s]."""

    def __init__(self, p: HoldParameters) -> None:
        self.parameters = p

    def step(self, wanted: float, angle: float) -> float:
        """For the wanted and the hub's own angle [rad]; 0 when it is off."""
        p = self.parameters
        error = wanted - angle
        if not p.enabled or abs(error) < p.dead_band:
            return 0.0
        return min(max(p.gain * error, -p.speed_limit), p.speed_limit)
