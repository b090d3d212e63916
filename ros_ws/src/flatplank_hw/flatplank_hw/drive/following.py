# SPDX-License-Identifier: Apache-2.0
"""Following error of a drive: how far the motor is from where its commands should have brought it.

As in LinuxCNC the allowed error grows with the speed:

    allowed = (standstill_speed + v) following_time + v^2 / (2 acceleration)

v is the largest change of speed since the drive obeyed last, or came into operation: commanded, or
missing, at most the commanded speed itself, so that a drive that runs away gets no more room by
that. In position control v is the largest speed. The first term is the travel during the reaction
of the drive, the second is that of speeding up, braking or reversing. The play of the gears does
not count: the motor's encoder sits in front of it. In velocity control the time without obedience
is limited, too, to that of a motor that reacts late and then brakes, allowed / v + v / (2
acceleration): one that has braked and creeps on would need long for the travel.

The travel of a cycle is told twice, by the counter and by the speed of the drive; the one that is
further from the command counts. Inputs that no longer change contradict themselves, the counter
stands and the speed does not, and cannot agree with a command unless they show a motor at rest.

Free rolling commands a torque, so the road takes the place of the commanded speed: a tire that
rolls turns between standing and V_x / r_l, because r_e is above the loaded radius r_l. Without a
sensible r_l, of a slip within that of the machine, r_0 takes its place. v is the largest speed
outside of that range, and the error is v times the time outside: a wheel that speeds up is noticed
as soon as one that had this speed from the beginning.
"""

from __future__ import annotations

import math

from flatplank_data.limits import LIMITS
from flatplank_hw.drive.modes import SetPoint
from flatplank_hw.drive.params import DriveParameters
from flatplank_hw.drive.safety import Situation
from flatplank_hw.drive.shaft import Shaft

OBEYS = 0.1
"""a drive obeys when its speed differs by less than this share from the commanded one; a larger
share hides a drive that slips, a smaller one counts the ripple of its speed"""
MOST = 1.0 + LIMITS["kappa"].high
"""largest speed of the machine's slip, relative to that of rolling"""


class Following:
    """Compares the set-point of the last cycle with the motion since then; `update` once per cycle
    of an enabled drive."""

    __slots__ = ("_from", "_off", "_p", "_peak", "_play", "_position", "_rest")

    def __init__(self, p: DriveParameters) -> None:
        self._p = p
        self._rest = p.standstill_speed * p.following_time
        self._play = p.torque_trip - p.torque_limit
        self._peak = self._from = self._off = 0.0
        self._position: float | None = None

    def reset(self, s: Situation) -> None:
        """Forget the past: the drive is not in operation, or it is homing."""
        self._position, self._peak, self._from, self._off = None, 0.0, 0.0, 0.0
        s.following_error, s.following_limit, s.torque_off_ns = 0.0, self._rest, 0

    def update(self, s: Situation, point: SetPoint, shaft: Shaft, dt_ns: int) -> None:
        """Update the following error and its limit in `s`; `dt_ns`: time since the last cycle."""
        position = shaft.position
        before, self._position = self._position, position
        if before is None:
            self._from = shaft.velocity
            return
        dt = dt_ns * 1e-9
        velocity, torque = point.velocity, point.torque
        travel, told = position - before, shaft.velocity * dt
        if torque == torque:
            off = not -self._play <= torque - shaft.torque <= self._play
            s.torque_off_ns = s.torque_off_ns + dt_ns if off else 0
            self._from = shaft.velocity
            if s.follows_reference:
                self._update_from_road(s, travel, told, dt)
            else:
                s.following_error, self._peak, self._off = 0.0, 0.0, 0.0
            return
        s.torque_off_ns = 0
        p, turns = self._p, shaft.velocity
        if point.position == point.position:
            error = point.position - position
            obeys = -self._rest <= error <= self._rest
            speed = max(abs(velocity), abs(turns))
            self._off = 0.0
        else:
            missing = _larger(velocity * dt - travel, velocity * dt - told)
            obeys = abs(missing) <= OBEYS * max(abs(velocity), p.standstill_speed) * dt
            error = 0.0 if obeys else s.following_error + missing
            if obeys:
                self._from = velocity
            self._off = 0.0 if obeys else self._off + dt
            lacking = min(abs(velocity - turns), abs(velocity))
            speed = max(lacking, abs(velocity - self._from))
        self._peak = peak = speed if obeys else max(self._peak, speed)
        self._set(s, error)
        if peak * self._off > s.following_limit + 0.5 * peak * peak / p.acceleration:
            s.following_limit = 0.0

    def _update_from_road(self, s: Situation, travel: float, told: float, dt: float) -> None:
        """Following error of a torque that a source commands: the tire rolls with the road."""
        p, loaded = self._p, s.loaded_radius
        radius = loaded if p.free_radius / MOST < loaded < p.free_radius else p.free_radius
        low = -p.standstill_speed * dt
        high = (s.plank_velocity / radius + p.standstill_speed) * dt
        beyond = _larger(_beyond(travel, low, high), _beyond(told, low, high))
        if beyond == 0.0:
            self._peak = self._off = error = 0.0
        else:
            self._off += dt
            if dt > 0.0:  # else two images have one stamp
                self._peak = max(self._peak, abs(beyond) / dt)
            error = -math.copysign(self._peak * self._off, beyond)
        self._set(s, error)

    def _set(self, s: Situation, error: float) -> None:
        p, peak = self._p, self._peak
        s.following_error = error
        s.following_limit = (
            self._rest + peak * p.following_time + 0.5 * peak * peak / p.acceleration
        )


def _larger(a: float, b: float) -> float:
    return a if abs(a) >= abs(b) else b


def _beyond(value: float, low: float, high: float) -> float:
    return value - min(max(value, low), high)
