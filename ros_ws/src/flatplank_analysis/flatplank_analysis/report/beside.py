# SPDX-License-Identifier: Apache-2.0
"""What slip runs tell beside the slip response: stiffness at rest, drive torque, side force."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flatplank_analysis.identify.grid import bin_means
from flatplank_analysis.identify.lateral import lateral_run
from flatplank_analysis.identify.linear import LinearFit, linear_run
from flatplank_analysis.identify.mean_response import has_mean, mean_response
from flatplank_analysis.identify.runs import StepRun
from flatplank_analysis.steady.stiffness import static_longitudinal_stiffness
from flatplank_analysis.steady.transmission import DriveState, drive_state
from flatplank_data.condition import Condition
from flatplank_data.errors import FlatplankError
from flatplank_data.table import MeasurementTable

SMALLEST_ANGLE = 0.3
"""[deg]; below it there is no lateral step to speak of"""
THIN = 0.01
"""grid on which the mean lateral force is kept [m]"""


@dataclass(frozen=True)
class LateralResult:
    """Start of rolling at a slip angle, mean of the runs of an operating point."""

    fit: LinearFit
    """of -Fy over tan(alpha): sigma_y [m], cornering stiffness at this angle [N]"""
    std_error: Sequence[float]
    """of sigma and force from the scatter of the runs, NaN for one run"""
    runs: int
    distance: np.ndarray
    """road since the start [m]"""
    force: np.ndarray
    """Fy [N]"""


@dataclass(frozen=True)
class DriveRun:
    """Torque of the wheel drive at the end of a run."""

    condition: Condition
    state: DriveState


@dataclass(frozen=True)
class Beside:
    """Of one operating point."""

    rest_stiffness: Sequence[float] = ()
    """C_x of the standing tire per run [N/m]"""
    drive: Sequence[DriveRun] = ()
    lateral: LateralResult | None = None


def rest_stiffness(table: MeasurementTable) -> float:
    """C_x while the plank moves and the wheel still stands [N/m]; NaN when it cannot be told."""
    if not all(table.has(name) for name in ("wheel_angle", "fx", "plank_position")):
        return math.nan
    return static_longitudinal_stiffness(table)


def drive_run(table: MeasurementTable) -> DriveRun | None:
    """Torques at the end of a run; None where they were not measured."""
    if not (table.has("motor_torque") and table.has("motor_velocity")):
        return None
    return DriveRun(table.info.condition, drive_state(table))


def lateral_start(table: MeasurementTable) -> StepRun | None:
    """The start of rolling at a slip angle as a step in side slip; None without one."""
    if abs(table.info.alpha_deg) < SMALLEST_ANGLE or not table.has("fy"):
        return None
    try:
        return lateral_run(table)
    except FlatplankError:
        return None


def lateral_result(runs: Sequence[StepRun]) -> LateralResult | None:
    """First-order response of the mean of the runs."""
    if not runs:
        return None
    if has_mean(runs):
        mean = mean_response(runs)
        fit, error = mean.fit, [float(v) for v in mean.std_error]
    else:
        fit = linear_run(runs[0].distance, runs[0].fx, runs[0].kappa)
        error = [math.nan, math.nan, math.nan]
    last = min(float(run.distance[-1]) for run in runs)
    x = runs[0].distance[runs[0].distance <= last]
    force = np.mean([np.interp(x, run.distance, -run.fx) for run in runs], axis=0)
    thin, (kept,) = bin_means(x, force[None], THIN)
    return LateralResult(fit, error, len(runs), thin, kept)


def beside(
    tables: Sequence[MeasurementTable],
) -> tuple[list[float], list[DriveRun], list[StepRun]]:
    """All of it for the tables of one condition."""
    stiffness = [rest_stiffness(t) for t in tables]
    drive = [drive_run(t) for t in tables]
    lateral = [lateral_start(t) for t in tables]
    return (
        [v for v in stiffness if math.isfinite(v)],
        [d for d in drive if d is not None],
        [s for s in lateral if s is not None],
    )
