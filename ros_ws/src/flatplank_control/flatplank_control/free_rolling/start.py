# SPDX-License-Identifier: Apache-2.0
"""The first centimetres of a free-rolling run: the tire is estimated, then the wheel makes up the
travel it has lost.

While the gears lock the wheel, the moving road winds the tire up: dFx/dx is its stiffness C_x =
C_Fk / sigma. Then the wheel is driven like a servo to the angle that belongs to the road's travel,
and the force loop takes over.

Stiffness and relaxation length come by least squares on the integrated transient tire, F = F_0
+ C_x (r_e theta - x) - (1/sigma) int F dx, with the travel x of the road and the angle theta of
the wheel since the start. Linear in C_x, C_x r_e, 1/sigma and F_0."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from flatplank_control.free_rolling.params import FreeRollingParameters
from flatplank_control.sequencer.params import FASTEST, JUMP
from flatplank_hw.samples import EncoderSample

SIGMA = (0.05, 2.0)
"""relaxation lengths that are believed [m]"""


class Tire(NamedTuple):
    """An estimate; NaN where the run does not determine it."""

    stiffness: float
    """C_x [N/m]"""
    relaxation: float
    """sigma [m]; the least certain of the three, and the one that the gains hardly need"""
    effective_radius: float
    """[m]"""


UNKNOWN = Tire(math.nan, math.nan, math.nan)


class StiffnessEstimator:
    """Sums of the normal equations, one sample per cycle; `solve` once at the end."""

    def __init__(self, radius: float) -> None:
        self._radius = radius
        self._sums = np.zeros((5, 5))
        self._integral = 0.0
        self._before: tuple[float, float] | None = None

    def add(self, x: float, angle: float, force: float) -> None:
        """Travel [m], wheel angle [rad] and force [N] since the start."""
        if self._before is not None:
            self._integral += 0.5 * (force + self._before[1]) * (x - self._before[0])
        self._before = (x, force)
        # metres times 1e3 and N m as they are: columns of one size
        row = np.array([1e3 * (self._radius * angle - x), 1e3 * x, self._integral, 1.0, force])
        self._sums += np.outer(row, row)

    def solve(self) -> Tire:
        """The tire; UNKNOWN when the run does not determine it."""
        a, b = self._sums[:4, :4].copy(), self._sums[:4, 4].copy()
        n, squares = a[3, 3], float(self._sums[4, 4])
        if n <= 8:
            return UNKNOWN
        try:
            inverse = np.linalg.inv(a)
        except np.linalg.LinAlgError:
            return UNKNOWN
        p = inverse @ b
        variance = max(squares - float(p @ b), 0.0) / (n - 4.0)
        # s is made with a guess of r_e: C_x r_e / guess = p0 and C_x (r_e / guess - 1) = p1
        stiffness, error = 1e3 * (p[0] - p[1]), 1e3 * math.sqrt(max(variance * inverse[0, 0], 0.0))
        if not (stiffness > 0.0 and error < 0.2 * stiffness):
            return UNKNOWN
        sigma = -1.0 / p[2] if p[2] < 0.0 else math.inf
        known = SIGMA[0] < sigma < SIGMA[1]
        radius = self._radius * p[0] / (p[0] - p[1])
        return Tire(float(stiffness), float(sigma) if known else math.nan, float(radius))


LISTEN, CATCH, OVER = range(3)
NOTICED = 25.0
"""force change from which samples count [N]"""
ENOUGH_FORCE = 450.0
"""[N]"""
ENOUGH_TRAVEL = 0.0012
"""from the first sample that counts [m]"""
LONGEST = 0.004
"""road without any force, then it is given up [m]"""
FEWEST = 5
"""samples"""
CATCH_AT_LEAST = 0.25
"""[s]"""
CATCH_AT_MOST = 0.05
"""[m] of road"""
ESTIMATE_OVER = 0.05
"""road over which the tire is estimated [m]"""


class Start:
    """One start; `stiffness` is NaN until it is estimated."""

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
        """estimate of the first centimetres, once they are over"""
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
        if -force < NOTICED:
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
