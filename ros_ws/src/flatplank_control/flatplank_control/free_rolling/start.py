# SPDX-License-Identifier: Apache-2.0
"""Start of a free-rolling run: estimates the tire, then lets the wheel recover the travel it has
lost.

While the self-locking gear holds the wheel, the moving road deflects the tire: dFx/dx is its
stiffness C_x = C_Fk / sigma. Then a servo drives the wheel to the angle that corresponds to the
road's travel. The force controller follows.

Stiffness and relaxation length follow by least squares from the integrated transient tire model

    F = F_0 + C_x (r_e theta - x) - (1/sigma) int F dx

with the travel x of the road and the angle theta of the wheel since the start. The model is linear
in C_x, C_x r_e, 1/sigma and F_0."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from flatplank_control.free_rolling.params import FreeRollingParameters
from flatplank_control.sequencer.params import FASTEST, JUMP
from flatplank_hw.samples import EncoderSample

SIGMA = (0.05, 2.0)
"""plausible relaxation lengths [m]"""


class Tire(NamedTuple):
    """Estimate of the tire; NaN where the run does not determine a value."""

    stiffness: float
    """C_x [N/m]"""
    relaxation: float
    """sigma [m]; the least certain of the three; the gains hardly depend on it"""
    effective_radius: float
    """[m]"""


UNKNOWN = Tire(math.nan, math.nan, math.nan)


class StiffnessEstimator:
    """Least-squares fit of the tire; `add` one sample per cycle, `solve` once at the end."""

    def __init__(self, radius: float) -> None:
        self._radius = radius
        self._sums = np.zeros((5, 5))
        self._integral = 0.0
        self._before: tuple[float, float] | None = None

    def add(self, x: float, angle: float, force: float) -> None:
        """Add a sample: travel [m], wheel angle [rad] and force [N] since the start."""
        if self._before is not None:
            self._integral += 0.5 * (force + self._before[1]) * (x - self._before[0])
        self._before = (x, force)
        # scale lengths by 1e3, so that all columns have a similar magnitude
        row = np.array([1e3 * (self._radius * angle - x), 1e3 * x, self._integral, 1.0, force])
        self._sums += np.outer(row, row)

    def solve(self) -> Tire:
        """Estimate the tire; UNKNOWN when the run does not determine it."""
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
        # s uses a guess of r_e: C_x r_e / guess = p0 and C_x (r_e / guess - 1) = p1
        stiffness, error = 1e3 * (p[0] - p[1]), 1e3 * math.sqrt(max(variance * inverse[0, 0], 0.0))
        if not (stiffness > 0.0 and error < 0.2 * stiffness):
            return UNKNOWN
        sigma = -1.0 / p[2] if p[2] < 0.0 else math.inf
        known = SIGMA[0] < sigma < SIGMA[1]
        radius = self._radius * p[0] / (p[0] - p[1])
        return Tire(float(stiffness), float(sigma) if known else math.nan, float(radius))


MEASURE_STIFFNESS, CATCH_UP, OVER = range(3)
"""phases of a start: the held tire gives C_x; the wheel recovers the lost travel; it is over"""
NOTICED = 25.0
"""smallest force change of a sample that is used [N]"""
ENOUGH_FORCE = 450.0
"""force change after which the stiffness is computed [N]"""
ENOUGH_TRAVEL = 0.0012
"""travel since the first used sample after which the stiffness is computed [m]"""
LONGEST = 0.004
"""road without a force change after which the wheel starts without an estimate [m]"""
FEWEST = 5
"""smallest number of samples for the stiffness"""
CATCH_UP_MIN_S = 0.25
"""shortest time of the servo phase [s]"""
CATCH_UP_MAX_M = 0.05
"""longest road of the servo phase [m]"""
ESTIMATE_OVER = 0.05
"""road over which stiffness, relaxation length and radius are estimated [m]"""


class Start:
    """One start of a run; `stiffness` is NaN until it is estimated."""

    def __init__(self, p: FreeRollingParameters) -> None:
        self._p = p
        self.phase = MEASURE_STIFFNESS
        self.stiffness = math.nan
        """C_x [N/m]"""
        self.torque = 0.0
        """low-passed torque of the servo [N m]"""
        self.travel = 0.0
        """travel of the road since the start [m]"""
        self.tire: Tire | None = None
        """estimate over the first ESTIMATE_OVER of road, once it is complete"""
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
        if self.phase == MEASURE_STIFFNESS:
            self._estimate_stiffness(x, force)
            if self.phase == MEASURE_STIFFNESS:
                return 0.0
        return self._catch_up(x, force, encoders)

    def observe(self, fx: float, encoders: EncoderSample) -> float:
        """Add a sample, also after the start; returns the road's travel since the start [m]."""
        if self._zero is None:
            self._zero, self._position = (encoders.wheel_angle, fx), encoders.plank_position
        step = encoders.plank_position - self._position
        self._position = encoders.plank_position
        # the motion trigger may set the position to zero meanwhile
        self.travel += step if abs(step) < JUMP else encoders.plank_velocity / self._p.rate_hz
        if self.travel < ESTIMATE_OVER:
            self._estimator.add(
                self.travel, encoders.wheel_angle - self._zero[0], fx - self._zero[1]
            )
        elif self.tire is None:
            self.tire = self._estimator.solve()
        return self.travel

    def _estimate_stiffness(self, x: float, force: float) -> None:
        if -force < NOTICED:
            if x > LONGEST:
                self.phase = CATCH_UP
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
            self.phase = CATCH_UP

    def _catch_up(self, x: float, force: float, encoders: EncoderSample) -> float:
        p = self._p
        radius = p.effective_radius
        ahead = (p.reference / self.stiffness) if self.stiffness > 0.0 else 0.0
        assert self._zero is not None, "set by observe"
        lost = x + ahead - radius * (encoders.wheel_angle - self._zero[0])
        # the plank velocity is a mean over a window; near the start the travel is more accurate
        speed = max(encoders.plank_velocity, 0.0)
        wanted = p.gear_ratio / radius * (speed + p.catch_rate * lost)
        wanted = min(max(wanted, 0.0), FASTEST * p.gear_ratio / radius * max(speed, 0.01))
        torque = p.start_torque + p.catch_gain * (wanted - encoders.motor_velocity)
        torque = min(max(torque, p.torque_min), p.torque_max)
        self.torque += self._smooth * (torque - self.torque)
        self._caught += 1
        settled = abs(lost) < p.caught and self._caught > CATCH_UP_MIN_S * p.rate_hz
        if settled or x > CATCH_UP_MAX_M:
            self.phase = OVER
        return torque
