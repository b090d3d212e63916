# SPDX-License-Identifier: Apache-2.0
"""Friction torque of the wheel drive (figures 5.3, 5.13) and efficiency (5.3, figure 5.4)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import astuple, dataclass

import numpy as np

from flatplank_analysis.starts import Value, mean_over_starts, value_over_starts
from flatplank_data.errors import FlatplankError
from flatplank_data.machine import GEAR_RATIO
from flatplank_data.table import MeasurementTable

CLEAR = 3.0
"""least net motor torque for an efficiency, over the scatter of the friction torque [-]"""
SMALLEST_NET = 0.02
"""least net motor torque for an efficiency [N m]"""
MOTOR_INERTIA = 0.00126
"""J_M of Table 5.1 [kg m2]"""
INERTIA_SHARE = 0.01
"""largest torque of the inertia in a sample, over that of the friction [-]"""
WINDOW = 0.2
"""time over which a speed must be constant [s]"""
TURN_COLUMNS = ("time", "motor_velocity", "motor_torque")


@dataclass(frozen=True)
class FrictionTorque:
    """M_F at the motor over its speed, from turns of the unloaded wheel."""

    speed: np.ndarray
    """[rad/s], increasing"""
    torque: np.ndarray
    """[N m]"""
    scatter: np.ndarray
    """standard deviation of the samples [N m]"""

    def __call__(self, speed: float) -> float:
        """M_F [N m] at a motor speed [rad/s]; held constant outside the measured range."""
        return float(np.interp(speed, self.speed, self.torque))

    @property
    def least_net(self) -> float:
        """Least net motor torque for an efficiency [N m]."""
        return max(CLEAR * float(np.median(self.scatter)), SMALLEST_NET)


def friction_torque(tables: Iterable[MeasurementTable], bins: int = 24) -> FrictionTorque:
    """Mean torque in bins of motor speed, over all unloaded turns at a constant speed.

    FlatplankError when no turn has one.
    """
    speed, torque = np.concatenate([_at_constant_speed(table) for table in tables], axis=1)
    edges = np.linspace(speed.min(), np.nextafter(speed.max(), np.inf), bins + 1)
    number = np.digitize(speed, edges) - 1
    used = [i for i in range(bins) if (number == i).sum() >= 5]
    if not used:
        what = "fewer than five samples at any motor speed"
        raise FlatplankError(what, "unloaded turns", "record longer")
    mean = np.array([[speed[number == i].mean(), torque[number == i].mean()] for i in used])
    scatter = np.array([torque[number == i].std(ddof=1) for i in used])
    return FrictionTorque(mean[:, 0], mean[:, 1], scatter)


def _at_constant_speed(table: MeasurementTable) -> np.ndarray:
    """Speed [rad/s] and torque [N m] of the motor (2, n), where no inertia takes part in it."""
    time, speed, torque = (table[name] for name in TURN_COLUMNS)
    ahead = np.minimum(np.searchsorted(time, time + WINDOW), len(time) - 1)
    behind = np.searchsorted(time, time - WINDOW)
    change = np.maximum(abs(speed[ahead] - speed), abs(speed - speed[behind])) / WINDOW
    keep = (change * MOTOR_INERTIA < INERTIA_SHARE * abs(torque)) & (abs(speed) > 1.0)
    if keep.sum() < 5:
        what = "the motor never turns at a constant speed"
        raise FlatplankError(what, table.info.file, "record turns in the mode velocity")
    return np.stack([abs(speed[keep]), abs(torque[keep])])


@dataclass(frozen=True)
class DriveState:
    """Means over the last part of a run, or over several runs."""

    motor_torque: float
    """M_M [N m]"""
    tire_torque: float
    """M_T = Fx r_l, reduced to the motor by the gear [N m]"""
    motor_velocity: float
    """[rad/s]"""


def mean_state(states: Sequence[DriveState], starts: Sequence[int]) -> DriveState:
    """Mean over the start angles of the wheel."""
    return DriveState(*mean_over_starts([astuple(s) for s in states], starts))


def efficiency(
    states: Sequence[DriveState], starts: Sequence[int], friction: FrictionTorque | None
) -> Value:
    """eta = M_T / (M_M - M_F) (5.3) of the mean over the start angles; NaN when braking.

    A ratio of single runs follows what turns with the wheel, and its mean does not lose it. The
    slewing drive is self-locking, so that a braking run gives no efficiency; nor does a net
    torque within the scatter of the friction. The error is linearised.
    """
    mean = mean_state(states, starts)
    if friction is None:
        return Value(math.nan, runs=len(states), note="no unloaded turn")
    net = mean.motor_torque - friction(mean.motor_velocity)
    if not (mean.tire_torque > 0.0 and net > friction.least_net):
        return Value(math.nan, runs=len(states), note="no driving torque")
    eta = mean.tire_torque / net
    pulls = [
        eta + (s.tire_torque - mean.tire_torque - eta * (s.motor_torque - mean.motor_torque)) / net
        for s in states
    ]
    return value_over_starts(pulls, starts)


def drive_state(table: MeasurementTable, length: float = 0.5) -> DriveState:
    """Torques over the last `length` [m] of a run."""
    x = table["plank_position"]
    keep = x > x.max() - length
    radius = table.get("loaded_radius")[keep]
    radius = np.where(np.isfinite(radius), radius, table.info.effective_rolling_radius)
    return DriveState(
        float(np.mean(table["motor_torque"][keep])),
        float(np.mean(table["fx"][keep] * radius)) / GEAR_RATIO,
        float(np.mean(table["motor_velocity"][keep])),
    )
