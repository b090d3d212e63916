# SPDX-License-Identifier: Apache-2.0
"""Effective rolling radius (5.22) at zero force, run by run and as mean over the start angles.

Three sources are compared, because the thesis found 0.3108 m with the controller and 0.3081 m with
the flexplates off. The free-rolling controller holds Fx at 50 N, slip control holds a speed, and a
wheel without flexplates rolls against its own resistance. At a force F the tire slips by F / C_Fk.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flatplank_analysis.starts import Value, mean_over_starts, value_over_starts
from flatplank_data.condition import Condition
from flatplank_data.machine import GEAR_RATIO
from flatplank_data.table import MeasurementTable

STEADY_FROM = 1.54
"""road displacement from which a free-rolling run has settled, thesis 5.6 [m]"""
BRAKING = 0.02
"""road at the end of a run on which plank and wheel brake one after the other [m]"""
FREE_WHEEL = "flexplates_off"
SOURCES = ("controller", "slip_control", FREE_WHEEL)


@dataclass(frozen=True)
class RadiusRun:
    """r_e of one run."""

    condition: Condition
    source: str
    radius: float
    """r_e by (5.22), not corrected for Fx [m]"""
    force: float
    """mean Fx over the same road [N]"""
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
    source = "controller" if info.measurement == "free_rolling" else "slip_control"
    source = info.r_e_source if info.r_e_source in SOURCES else source
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
    return RadiusRun(info.condition, source, radius, force, load, info.start)


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


@dataclass(frozen=True)
class RadiusValue:
    """r_e of one operating point from one source, mean over the start angles."""

    point: Condition
    source: str
    measured: Value
    """r_e by (5.22) [m]"""
    corrected: Value
    """r_e at Fx = 0 [m]"""
    force: float
    """mean Fx during the measurement [N]"""
    load: float
    """mean Fz during the measurement [N]"""
    slip_stiffness: float = math.nan
    """slip stiffness for the correction [N]"""
    starts: int = 1
    """number of different start angles"""


def mean_radii(
    runs: Sequence[RadiusRun], stiffness: Mapping[Condition, float]
) -> list[RadiusValue]:
    """r_e by operating point and source; `stiffness`: C_Fk of a point [N], where it is known."""
    groups: dict[tuple[Condition, str], list[RadiusRun]] = {}
    for run in runs:
        point = run.condition.operating_point._replace(measurement="slip")
        groups.setdefault((point, run.source), []).append(run)
    return [
        _mean_radius(point, source, own, stiffness.get(point, math.nan))
        for (point, source), own in groups.items()
    ]


def _mean_radius(
    point: Condition, source: str, runs: Sequence[RadiusRun], c: float
) -> RadiusValue:
    starts = [run.start for run in runs]
    known = math.isfinite(c)
    at_zero = [run.corrected(c) if known else run.radius for run in runs]
    force, load = mean_over_starts([(run.force, run.load) for run in runs], starts)
    return RadiusValue(
        point,
        source,
        value_over_starts([run.radius for run in runs], starts),
        value_over_starts(at_zero, starts, "" if known else "not corrected: no slip stiffness"),
        float(force),
        float(load),
        c,
        len(set(starts)),
    )
