# SPDX-License-Identifier: Apache-2.0
"""The wheel's angle follows the road's travel: what a late start has lost is made up, slip holds
whatever the speed does.

The wanted angle is the integral of cos(alpha) (1 + kappa) / r_e over the travel. The wheel
encoder is compared with it,
so that the gap of the drive is made up too; its steps are crossed faster than the bus samples and
average out.
"""

from __future__ import annotations

import math

from flatplank_control.sequencer.params import SequencerParameters
from flatplank_control.travel import FASTEST, JUMP
from flatplank_hw.samples import EncoderSample


class Follower:
    """One run; `correction` [rad/s] is added to the speed of the sequencer."""

    __slots__ = (
        "_angle",
        "_error",
        "_meshed",
        "_position",
        "_wanted",
        "lost",
        "parameters",
        "travel",
    )

    def __init__(self, p: SequencerParameters) -> None:
        self.parameters = p
        parts = (p.mesh_turn_cos, p.mesh_turn_sin, p.mesh_tooth_cos, p.mesh_tooth_sin)
        self._meshed = any(parts)
        self.reset()

    def reset(self) -> None:
        """Forget the run."""
        self._position: float | None = None
        self._error = 0.0
        self._angle = self._wanted = 0.0
        self.travel = 0.0
        """of the road since it rested [m]"""
        self.lost = 0.0
        """wanted angle less the wheel's [rad]"""

    def step(self, encoders: EncoderSample, per_metre: float) -> float:
        """Correction of this cycle for a wheel that should turn `per_metre` [rad/m]."""
        p = self.parameters
        on_road = p.use_road_encoder and encoders.road_position == encoders.road_position
        position = encoders.road_position if on_road else encoders.plank_position
        before = self._position
        rests = before is None or not encoders.plank_moving
        if before is None or (rests and self.travel == 0.0):
            # from here on travel counts
            self._angle, self._wanted = encoders.wheel_angle, 0.0
            self._position = position
            self._error = 0.0 if on_road else self._mesh(position)
            return 0.0
        step = position - before
        self._position = position
        if not -JUMP < step < JUMP:
            step = encoders.plank_velocity / p.rate_hz
            self._error = self._mesh(position)
        if not on_road:
            step = step * p.road_scale + self._mesh_step(position)
        self.travel += step
        self._wanted += step * per_metre
        self.lost = self._wanted - (encoders.wheel_angle - self._angle)
        correction = p.follow_rate * self.lost
        most = (FASTEST - 1.0) * p.commanded_speed * per_metre
        return min(max(correction, -0.5 * most), most)

    def _mesh_step(self, position: float) -> float:
        """Change of the mesh's error since the last cycle [m]."""
        if not self._meshed:
            return 0.0
        before, self._error = self._error, self._mesh(position)
        return self._error - before

    def _mesh(self, position: float) -> float:
        """Error of rack and pinion at a plank position [m]."""
        if not self._meshed:
            return 0.0
        p = self.parameters
        turn, tooth = position / p.pinion_pitch_radius, math.tau * position / p.tooth_pitch
        return (
            p.mesh_turn_cos * math.cos(turn) + p.mesh_turn_sin * math.sin(turn)
            + p.mesh_tooth_cos * math.cos(tooth) + p.mesh_tooth_sin * math.sin(tooth)
        )  # fmt: skip
