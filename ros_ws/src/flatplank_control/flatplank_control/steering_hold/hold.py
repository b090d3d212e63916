# SPDX-License-Identifier: Apache-2.0
"""Speed of the steering motor that keeps the hub's angle against the play of its worm drive.

With an encoder on the hub the gap is seen and crossed. With the encoder on the worm, as in the
thesis (3.1, issue 10), the gap is not seen; but the tire's moment about z says at which side of
it the hub lies, and the play itself is on the pre-flight sheet.
"""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_data.params import Params, param


@dataclass(frozen=True)
class HoldParameters(Params):
    """Gains; `play` 0 when the encoder sits on the hub."""

    enabled: bool = param(False, "hold the hub's angle instead of the motor's")
    gain: float = param(6.0, "speed over angle error", unit="1/s", bounds=(0.1, 100.0))
    dead_band: float = param(
        3.5e-4, "an error that is left alone: 0.02 deg", unit="rad", bounds=(0.0, 0.1)
    )
    speed_limit: float = param(0.035, "2 deg/s", unit="rad/s", bounds=(1e-4, 1.0))
    play: float = param(
        0.0, "gap of the worm that the encoder does not see", unit="rad", bounds=(0.0, 0.1)
    )
    play_moment: float = param(
        15.0, "moment about z from which the hub has crossed the gap", unit="N m",
        bounds=(0.0, 1e4),
    )  # fmt: skip


class SteeringHold:
    """`step` gives the speed of the steering axis [rad/s]."""

    def __init__(self, p: HoldParameters) -> None:
        self.parameters = p
        self.reset()

    def reset(self) -> None:
        """The hub lies in the middle of its gap."""
        self.side = 0.0

    def step(self, wanted: float, angle: float, moment: float = 0.0) -> float:
        """For the wanted and the measured angle [rad] and the tire's moment about z [N m]; 0 when
        it is off."""
        p = self.parameters
        if abs(moment) > p.play_moment:
            # a positive moment turns the wheel to the left, which lowers the slip angle
            self.side = -0.5 * p.play if moment > 0.0 else 0.5 * p.play
        error = wanted - angle - self.side
        if not p.enabled or abs(error) < p.dead_band:
            return 0.0
        return min(max(p.gain * error, -p.speed_limit), p.speed_limit)
