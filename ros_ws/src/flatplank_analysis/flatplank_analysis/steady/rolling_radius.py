# SPDX-License-Identifier: Apache-2.0
"""Effective rolling radius (5.22), and its correction to zero longitudinal force.

Three sources are compared, since the thesis found 0.3108 m with the controller and 0.3081 m with
the flexplates off: the free-rolling controller holds 50 N, slip control holds a speed, a wheel
without flexplates rolls with its own resistance. At a force F the tire slips by F / C_Fk.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flatplank_analysis.steady.value import Value, mean_value
from flatplank_data.condition import Condition
from flatplank_data.machine import GEAR_RATIO
from flatplank_data.table import MeasurementTable

STEADY_FROM = 1.54
"""thesis 5.6: settled from here on [m]"""
BRAKING = 0.02
"""at the end of a run the plank brakes, and the wheel stops after it [m]"""
FREE_WHEEL = "flexplates_off"
SOURCES = ("controller", "slip_control", FREE_WHEEL)


@dataclass(frozen=True)
class RadiusRun:
    """r_e of one run."""

    condition: Condition
    source: str
    radius: float
    """(5.22) as it is [m]"""
    force: float
    """mean Fx over the same road [N]"""
    encoder_radius: float
    """the same from the wheel encoder [m]"""
    load: float
    """mean Fz over the same road [N]; nominal where it was not measured"""
    start: int = 1
    """1, 2, 3: wheel started at 0, 120, 240 deg"""

    def corrected(self, slip_stiffness: float) -> float:
        """r_e at Fx = 0: r_e (1 + F / C_Fk), with C_Fk [N]."""
        return self.radius * (1.0 + self.force / slip_stiffness)


def radius_of_run(table: MeasurementTable) -> RadiusRun:
    """r_e from the road on which a run rolls freely."""
    info, x = table.info, table["plank_position"]
    source = info.r_e_source if info.r_e_source in SOURCES else _source(table)
    first, last = STEADY_FROM, float(x.max()) - BRAKING
    if info.measurement == "slip":
        step = info.step_position if math.isfinite(info.step_position) else last
        first, last = (step - 0.4, step) if info.kappa else (step, last)
    keep = (x >= first) & (x <= last)
    if keep.sum() < 10:
        keep = x >= 0.6 * float(x.max())
    cosine = math.cos(math.radians(info.alpha_deg))
    time = table["time"][keep]
    speed = float(np.ptp(x[keep])) / float(np.ptp(time))
    encoder = _over(speed * cosine, _rate(table, "wheel_angle", "wheel_velocity", keep))
    motor = _over(GEAR_RATIO * speed * cosine, _rate(table, "", "motor_velocity", keep))
    radius = encoder if source == FREE_WHEEL or math.isnan(motor) else motor
    load = float(np.mean(table["fz"][keep])) if table.has("fz") else info.fz
    force = float(np.mean(table["fx"][keep]))
    return RadiusRun(info.condition, source, radius, force, encoder, load, info.start)


def _source(table: MeasurementTable) -> str:
    return "controller" if table.info.measurement == "free_rolling" else "slip_control"


def _over(speed: float, omega: float) -> float:
    return speed / omega if omega else math.nan


def _rate(table: MeasurementTable, angle: str, velocity: str, keep: np.ndarray) -> float:
    """Mean angular velocity [rad/s], from the angle where there is one."""
    time = table["time"][keep]
    if angle and table.has(angle):
        return float(np.polyfit(time - time.mean(), table[angle][keep], 1)[0])
    if table.has(velocity):
        return float(np.trapezoid(table[velocity][keep], time) / np.ptp(time))
    return math.nan


def radius_table(
    runs: Sequence[RadiusRun], slip_stiffness: float = math.nan
) -> dict[tuple[Condition, str], Value]:
    """Mean r_e over start angles per operating point and source; corrected where C_Fk is known."""
    groups: dict[tuple[Condition, str], list[float]] = {}
    for run in runs:
        known = math.isfinite(slip_stiffness)
        value = run.corrected(slip_stiffness) if known else run.radius
        key = (run.condition.operating_point._replace(measurement=""), run.source)
        groups.setdefault(key, []).append(value)
    return {key: mean_value(values) for key, values in groups.items()}
