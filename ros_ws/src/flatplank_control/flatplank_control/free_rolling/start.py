# SPDX-License-Identifier: Apache-2.0
"""The first centimetres of a free-rolling run: the tire is felt, then the wheel makes up the
travel it has lost.

While the gears lock the wheel, the moving road winds the tire up: dFx/dx is its stiffness C_x =
C_Fk / sigma. Then the
wheel is driven like a servo to the angle that belongs to the road's travel, and the force loop
takes over.
"""

from __future__ import annotations

import math

from flatplank_control.free_rolling.params import FreeRollingParameters
from flatplank_control.free_rolling.stiffness_estimator import StiffnessEstimator, Tire
from flatplank_control.travel import FASTEST, JUMP
from flatplank_hw.samples import EncoderSample

LISTEN, CATCH, OVER = range(3)
FELT = 25.0
"""force change from which the tire is felt [N]"""
ENOUGH_FORCE = 450.0
"""[N]"""
ENOUGH_TRAVEL = 0.0012
"""from the first felt sample on [m]"""
LONGEST = 0.004
"""road without any force, then it is given up [m]"""
FEWEST = 5
"""samples"""
CATCH_AT_LEAST = 0.25
"""[s]"""
CATCH_AT_MOST = 0.05
"""[m] of road"""
ESTIMATE_OVER = 0.05
"""road from which the tire is told [m]"""


class Start:
    """One start; `stiffness` is NaN until it was felt."""

    def __init__(self, p: FreeRollingParameters) -> None:
        self._p = p
        self.phase = LISTEN
        self.stiffness = math.nan
        """C_x [N/m]"""
        self.torque = 0.0
        """slow mean of what the servo needs [N m]"""
        self.travel = 0.0
        """of the road since the start [m]"""
        self.tire: Tire | None = None
        """what the first centimetres have told, once they are over"""
        self._estimator = StiffnessEstimator(p.effective_radius)
        self._zero: tuple[float, float] | None = None
        self._position = 0.0
        self._n = 0
        self._sums = (0.0, 0.0, 0.0, 0.0)
        self._first = math.nan
        self._caught = 0
        self._smooth = -math.expm1(-1.0 / (0.05 * p.rate_hz))

    def step(self, fx: float, encoders: EncoderSample) -> float:
        """Motor torque of this cycle [N m]."""
        x = self.observe(fx, encoders)
        assert self._zero is not None, "set by observe"
        force = fx - self._zero[1]
        if self.phase == LISTEN:
            self._listen(x, force)
            if self.phase == LISTEN:
                return 0.0
        return self._catch(x, force, encoders)

    def observe(self, fx: float, encoders: EncoderSample) -> float:
        """Take in a sample, also after the start; the road's travel since then [m]."""
        if self._zero is None:
            self._zero, self._position = (encoders.wheel_angle, fx), encoders.plank_position
        step = encoders.plank_position - self._position
        self._position = encoders.plank_position
        # the motion trigger sets the position to zero on the way
        self.travel += step if abs(step) < JUMP else encoders.plank_velocity / self._p.rate_hz
        if self.travel < ESTIMATE_OVER:
            self._estimator.add(
                self.travel, encoders.wheel_angle - self._zero[0], fx - self._zero[1]
            )
        elif self.tire is None:
            self.tire = self._estimator.solve()
        return self.travel

    def _listen(self, x: float, force: float) -> None:
        if -force < FELT:
            if x > LONGEST:
                self.phase = CATCH
            return
        if not self._n:
            self._first = x
        sx, sf, sxx, sxf = self._sums
        self._sums = (sx + x, sf + force, sxx + x * x, sxf + x * force)
        self._n += 1
        if self._n >= FEWEST and (x - self._first > ENOUGH_TRAVEL or -force > ENOUGH_FORCE):
            sx, sf, sxx, sxf = self._sums
            spread = sxx - sx * sx / self._n
            if spread > 0.0:
                self.stiffness = -(sxf - sx * sf / self._n) / spread
            self.phase = CATCH

    def _catch(self, x: float, force: float, encoders: EncoderSample) -> float:
        p = self._p
        radius = p.effective_radius
        ahead = (p.reference / self.stiffness) if self.stiffness > 0.0 else 0.0
        assert self._zero is not None, "set by observe"
        lost = x + ahead - radius * (encoders.wheel_angle - self._zero[0])
        # the plank's own velocity comes from a window: near the start its travel says more
        speed = max(encoders.plank_velocity, 0.0)
        wanted = p.gear_ratio / radius * (speed + p.catch_rate * lost)
        wanted = min(max(wanted, 0.0), FASTEST * p.gear_ratio / radius * max(speed, 0.01))
        torque = p.start_torque + p.catch_gain * (wanted - encoders.motor_velocity)
        torque = min(max(torque, p.torque_min), p.torque_max)
        self.torque += self._smooth * (torque - self.torque)
        self._caught += 1
        settled = abs(lost) < p.caught and self._caught > CATCH_AT_LEAST * p.rate_hz
        if settled or x > CATCH_AT_MOST:
            self.phase = OVER
        return torque
