# SPDX-License-Identifier: Apache-2.0
"""Friction torque of the wheel drive (figures 5.3, 5.13) and efficiency (5.3, figure 5.4)."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from flatplank_analysis.data.table import MeasurementTable
from flatplank_analysis.steady.rolling_radius import GEAR


@dataclass(frozen=True)
class FrictionTorque:
    """M_F at the motor over its speed, from turns with the wheel hanging free."""

    speed: np.ndarray
    """[rad/s], increasing"""
    torque: np.ndarray
    """[N m]"""
    scatter: np.ndarray
    """standard deviation of the samples [N m]"""

    def __call__(self, speed: float) -> float:
        """M_F [N m] at a motor speed [rad/s]; held constant outside the measured range."""
        return float(np.interp(speed, self.speed, self.torque))


def friction_torque(tables: Iterable[MeasurementTable], bins: int = 24) -> FrictionTorque:
    """Mean torque in bins of motor speed, over all unloaded turns."""
    parts = [(t["motor_velocity"], t["motor_torque"]) for t in tables]
    speed = np.concatenate([s for s, _ in parts])
    torque = np.concatenate([m for _, m in parts])
    edges = np.linspace(speed.min(), np.nextafter(speed.max(), np.inf), bins + 1)
    number = np.digitize(speed, edges) - 1
    used = [i for i in range(bins) if (number == i).sum() >= 5]
    mean = np.array([[speed[number == i].mean(), torque[number == i].mean()] for i in used])
    scatter = np.array([torque[number == i].std(ddof=1) for i in used])
    if not used:
        raise ValueError("unloaded turns: fewer than five samples at any speed; record longer")
    return FrictionTorque(mean[:, 0], mean[:, 1], scatter)


def efficiency(table: MeasurementTable, friction: FrictionTorque) -> float:
    """eta = M_T / (M_M - M_F) over the last part of a driving run (5.3); NaN when braking.

    M_T = Fx r_l is the tire's torque, reduced to the motor by the gear. The slewing drive locks
    itself, so a braking run tells nothing.
    """
    x = table["plank_position"]
    keep = x > x.max() - 0.5
    radius = table.get("loaded_radius")[keep]
    radius = np.where(np.isfinite(radius), radius, table.info.effective_rolling_radius)
    tire = float(np.mean(table["fx"][keep] * radius)) / GEAR
    motor = float(np.mean(table["motor_torque"][keep]))
    net = motor - friction(float(np.mean(table["motor_velocity"][keep])))
    return tire / net if tire > 0.0 and net > 0.0 else math.nan
