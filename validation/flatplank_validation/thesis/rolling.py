# SPDX-License-Identifier: Apache-2.0
"""Free-rolling runs of chapter 5: simulated by (5.15) to (5.21), and measured on the twin."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from flatplank_analysis.post.gridding import low_pass, on_grid
from flatplank_analysis.post.motion import until_stop
from flatplank_analysis.steady.rolling_radius import radius_of_run
from flatplank_analysis.steady.settling import REFERENCE_FORCE, fit_exponential
from flatplank_control.free_rolling.params import FreeRollingParameters
from flatplank_data.campaign import Campaign
from flatplank_data.machine import GEAR_RATIO
from flatplank_data.table import MeasurementTable
from flatplank_validation.free_rolling.nonlinear import (
    FIGURE_5_11,
    Nonlinear,
    Run,
    friction_table,
    settling_distance,
    simulate,
)
from flatplank_validation.thesis.lab import STARTS, Lab

COLUMNS = (
    "time", "plank_position", "plank_velocity", "wheel_angle", "motor_velocity", "motor_torque",
    "fx", "fz",
)  # fmt: skip
NOMINAL = 3700.0
TRIGGER_JUMP = 1e-3
"""least change of the plank position in one sample that is its zeroing by the trigger [m]"""
MOVED = 5e-5
"""travel after which the plank has begun to move [m]"""
STEADY = 1.5
"""road at the end over which the steady error is taken [m]"""
WAYS = {"thesis": "the thesis's controller", "ours": "ours"}
"""suffix of a campaign -> who made the controller"""


def runs(lab: Lab, name: str) -> list[MeasurementTable]:
    """Free-rolling runs of a campaign, from the motion trigger to the stop of the plank."""
    if name not in lab.kept:
        lab.kept[name] = [until_stop(table) for table in lab.tables(name, COLUMNS)]
    return lab.kept[name]


def starts(lab: Lab) -> list[MeasurementTable]:
    """Runs of the thesis's controller from the first movement of the plank on, by load."""
    if STARTS not in lab.kept:
        found = [
            run.table(COLUMNS, check=False) for run in Campaign.load(lab.measured(STARTS)).runs
        ]
        lab.kept[STARTS] = [_from_standstill(t) for t in found]
    return sorted(lab.kept[STARTS], key=lambda t: t.info.fz)


def _from_standstill(table: MeasurementTable) -> MeasurementTable:
    """The run with the position counted from where the plank began to move; up to its stop."""
    x = table["plank_position"].copy()
    jump = int(np.argmax(np.abs(np.diff(x)))) + 1
    if abs(x[jump] - x[jump - 1]) > TRIGGER_JUMP:
        x[:jump] += x[jump] - x[jump - 1]
    moving = np.flatnonzero(x > x[0] + MOVED)
    first = max(int(moving[0]) - 1, 0)
    columns = {n: v[first:] for n, v in table.columns.items()} | {
        "plank_position": x[first:] - x[first]
    }
    return until_stop(MeasurementTable(columns, table.info))


def nominal(lab: Lab) -> MeasurementTable:
    """The Toyo at its nominal load from 0 deg, under the thesis's controller."""
    return next(t for t in starts(lab) if t.info.fz == NOMINAL)


@cache
def simulated() -> Run:
    """The simulation of section 5.5, with the friction that it had before it was scaled."""
    return simulate(Nonlinear(friction=friction_table(FIGURE_5_11)), FreeRollingParameters())


def improved(lab: Lab) -> Run:
    """The same with the measured road speed, and the friction scaled to the measured torque."""
    kept: dict[str, Any] = lab.kept
    if "improved" not in kept:
        table = nominal(lab)
        late = table["plank_position"] > float(table["plank_position"].max()) - STEADY
        torque = float(np.mean(table["motor_torque"][late]))
        theirs = float(np.mean(simulated().torque[-len(simulated().torque) // 4 :]))
        scaled = friction_table(FIGURE_5_11 * torque / theirs)
        grid = on_grid(table, ["plank_velocity"])
        x, v = grid.position, low_pass(grid["plank_velocity"])
        # the start of the road is the acceleration of the simulation, as in section 5.5
        rolls = np.isfinite(v) & (x >= x[np.argmax(v > np.nanmedian(v))])
        x, v = x[rolls][::10], v[rolls][::10]
        kept["improved"] = simulate(
            Nonlinear(friction=scaled), FreeRollingParameters(),
            speed=lambda at: float(np.interp(at, x, v)),
        )  # fmt: skip
    return kept["improved"]


def simulated_settling(run: Run) -> float:
    """Settling distance of a simulation by Appendix E [m]."""
    return settling_distance(run.position, run.force)


def force(table: MeasurementTable) -> tuple[np.ndarray, np.ndarray]:
    """Road displacement [m] and low-passed Fx [N]."""
    grid = on_grid(table, ["fx"])
    return grid.position, low_pass(grid["fx"])


def settling(table: MeasurementTable) -> float:
    """Settling distance by Appendix E [m]."""
    grid = on_grid(table, ["fx"])
    return fit_exponential(grid.position, grid["fx"]).settles_at()


def steady_error(table: MeasurementTable) -> float:
    """Mean Fx over the last 1.5 m less the reference, relative to it [%]."""
    x = table["plank_position"]
    late = (x > float(x.max()) - STEADY) & np.isfinite(table["fx"])
    return 100.0 * (float(np.mean(table["fx"][late])) / REFERENCE_FORCE - 1.0)


def radius(table: MeasurementTable) -> float:
    """r_e by (5.22) [m]."""
    return radius_of_run(table).radius


def slip(table: MeasurementTable) -> tuple[np.ndarray, np.ndarray]:
    """Slip over road displacement with the r_e of the run itself; from motor and plank speed."""
    grid = on_grid(table, ["motor_velocity", "plank_velocity"])
    speed = low_pass(grid["plank_velocity"])
    turned = low_pass(grid["motor_velocity"]) / GEAR_RATIO
    with np.errstate(divide="ignore", invalid="ignore"):
        kappa = radius(table) * turned / speed - 1.0
    return grid.position, kappa


def slip_gone(table: MeasurementTable, band: float = 0.1) -> float:
    """Road after which |slip| stays below `band`: the wheel overshoots when it catches up [m]."""
    x, kappa = slip(table)
    outside = np.flatnonzero(np.abs(kappa) >= band)
    return float(x[outside[-1]]) if outside.size else 0.0


def swing(table: MeasurementTable) -> float:
    """Half of the range of Fx over the last 1.5 m [N]."""
    x = table["plank_position"]
    late = table["fx"][x > float(x.max()) - STEADY]
    return 0.5 * float(np.ptp(late[np.isfinite(late)]))
