# SPDX-License-Identifier: Apache-2.0
"""Tables beside the models: stiffness at rest, drive, side force, sources of the radius."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from flatplank_analysis.report.results import CampaignResult, PointResult
from flatplank_analysis.report.tables import (
    POINT_COLUMNS,
    RadiusValue,
    Table,
    point_cells,
    radius_values,
)
from flatplank_analysis.steady.transmission import FrictionTorque
from flatplank_analysis.steady.value import mean_value

FLAT = 2e-4
"""Radii that differ by less agree [-]"""


def friction_of(result: CampaignResult) -> FrictionTorque | None:
    """M_F from the unloaded turns of the campaign."""
    found = result.extras.get("friction_torque")
    if not found:
        return None
    return FrictionTorque(found["speed"], found["torque"], found["scatter"])


def friction_table(result: CampaignResult) -> Table:
    """Figure 5.3 as numbers."""
    curve = friction_of(result)
    rows = [] if curve is None else np.column_stack([curve.speed, curve.torque, curve.scatter])
    header = ("motor speed [rad/s]", "friction torque [N m]", "± of a sample [N m]")
    note = "Motor torque of unloaded turns, mean per speed."
    return Table(
        "friction_torque",
        "Friction of the wheel drive",
        header,
        [list(map(float, r)) for r in rows],
        note,
    )


def efficiencies(result: CampaignResult) -> dict[object, list[float]]:
    """eta by (5.3) of every driving run, by condition."""
    curve = friction_of(result)
    out: dict[object, list[float]] = {}
    for run in (r for p in result.points for r in p.beside.drive) if curve else ():
        value = run.state.efficiency(curve)
        if math.isfinite(value):
            out.setdefault(run.condition, []).append(value)
    return out


def transmission_table(result: CampaignResult) -> Table:
    """Figures 5.4 and 5.13 as numbers."""
    curve, eta = friction_of(result), efficiencies(result)
    groups: dict = {}
    for run in (r for p in result.points for r in p.beside.drive):
        groups.setdefault(run.condition, []).append(run.state)
    rows = []
    for condition in sorted(groups, key=lambda c: c.sort_key):
        states = groups[condition]
        speed = float(np.mean([s.motor_velocity for s in states]))
        value = mean_value(eta.get(condition, []))
        rows.append(
            [
                *point_cells(condition),
                f"{100.0 * condition.kappa:.10g}",
                float(np.mean([s.motor_torque for s in states])),
                float(np.mean([s.tire_torque for s in states])),
                curve(speed) if curve else math.nan,
                100.0 * value.value,
                100.0 * value.std_error,
                str(len(states)),
            ]
        )
    header = (
        *POINT_COLUMNS,
        "κ [%]",
        "M_M [N m]",
        "M_T / i [N m]",
        "M_F [N m]",
        "η [%]",
        "± [%]",
        "runs",
    )
    lack = "" if curve else " No unloaded turn was measured: without M_F there is no efficiency."
    note = (
        "Over the last half metre; η = M_T / (M_M − M_F) (5.3) of driving runs: the slewing drive "
        f"locks itself, so a braking tire takes no motor torque.{lack}"
    )
    return Table("transmission", "Wheel drive: torque and efficiency", header, rows, note)


def stiffness_table(result: CampaignResult) -> Table:
    """Longitudinal stiffness of the standing tire beside that of the rolling one."""
    rows = []
    for point in result.points:
        rest = mean_value(point.beside.rest_stiffness)
        rolling = rolling_stiffness(point)
        if not rest.runs and not math.isfinite(rolling):
            continue
        rows.append(
            [
                *point_cells(point.point),
                1e-3 * rest.value,
                1e-3 * rest.std_error,
                str(rest.runs),
                1e-3 * rolling,
                rest.value / rolling,
            ]
        )
    header = (
        *POINT_COLUMNS,
        "C_x at rest [kN/m]",
        "± [kN/m]",
        "runs",
        "C_x rolling [kN/m]",
        "rest / rolling",
    )
    note = (
        "At rest: the plank moves and the wheel is still held, while Fx is small. "
        "Rolling: C_Fκ / σx by (7.27). Play between road and plank makes the first one too small."
    )
    return Table("longitudinal_stiffness", "Longitudinal stiffness", header, rows, note)


def rolling_stiffness(point: PointResult) -> float:
    """C_x = C_Fk / sigma_x (7.7) of the carcass fit [N/m], NaN without one."""
    fit = point.carcass
    if fit is None or not (fit.sigma_x.determined and fit.slip_stiffness.determined):
        return math.nan
    return fit.slip_stiffness.value / fit.sigma_x.value


def lateral_table(result: CampaignResult) -> Table:
    """Side force from the start of rolling."""
    rows = []
    for point in result.points:
        found = point.beside.lateral
        if found is None:
            continue
        fit, error = found.fit, found.std_error
        known = fit.sigma.determined
        spring = fit.slip_stiffness.value / (fit.sigma.value - _half_length(point))
        rows.append(
            [
                *point_cells(point.point),
                fit.sigma.value if known else math.nan,
                error[0],
                1e-3 * fit.slip_stiffness.value,
                1e-3 * error[1] / abs(fit.kappa),
                -fit.steady_force.value,
                error[1],
                1e-3 * spring if fit.settled and spring > 0.0 else math.nan,
                str(found.runs),
                "yes" if fit.settled else "no",
            ]
        )
    header = (
        *POINT_COLUMNS,
        "σy [m]",
        "± [m]",
        "C′Fα [kN/rad]",
        "± [kN/rad]",
        "Fy,ss [N]",
        "± [N]",
        "c_cy [kN/m]",
        "runs",
        "settled",
    )
    note = (
        "The slip angle is set before the road moves: its step is the start. Linear model of Fy "
        "over tan α up to the slip step, mean of the runs. c_cy by (7.27) in y with σ_c = a."
    )
    return Table("lateral", "Lateral transient", header, rows, note)


def _half_length(point: PointResult) -> float:
    return point.carcass.half_length if point.carcass is not None else 0.0


def source_table(result: CampaignResult) -> Table:
    """The thesis asks why r_e differs between its sources."""
    groups: dict = {}
    for value in radius_values(result):
        groups.setdefault(value.point, []).append(value)
    rows = [row for values in groups.values() for row in _pairs(values)]
    header = (
        *POINT_COLUMNS,
        "sources",
        "difference [%]",
        "by the force [%]",
        "left [%]",
        "left as force [N]",
        "reading",
    )
    note = (
        "First source less the second. By the force: Fx differs, and F makes a slip F/C_Fκ. What "
        "is left would need an error of Fx of that size, or belongs to the encoders."
    )
    return Table("radius_sources", "Why rolling radii differ", header, rows, note)


def _pairs(values: Sequence[RadiusValue]) -> list[list[str | float]]:
    out: list[list[str | float]] = []
    for i, one in enumerate(values):
        for other in values[i + 1 :]:
            whole = one.measured.value / other.measured.value - 1.0
            left = one.corrected.value / other.corrected.value - 1.0
            stiffness = max(one.slip_stiffness, other.slip_stiffness)
            out.append(
                [
                    *point_cells(one.point),
                    f"{one.source} − {other.source}".replace("_", " "),
                    100.0 * whole,
                    100.0 * (whole - left),
                    100.0 * left,
                    left * stiffness,
                    _reading(one, other, left),
                ]
            )
    return out


def _reading(one: RadiusValue, other: RadiusValue, left: float) -> str:
    """What is behind the remainder, as far as these runs tell."""
    if not math.isfinite(left):
        return "no slip stiffness: the force's share is not known"
    error = math.hypot(_relative(one), _relative(other))
    if abs(left) < FLAT or (error > 0.0 and abs(left) < 2.0 * error):
        return "the force explains it"
    if "flexplates_off" in (one.source, other.source):
        return "free wheel: told by the wheel encoder, the others by the motor's"
    fewest = min(one, other, key=lambda v: v.starts)
    if fewest.starts < 3:
        return (
            f"{fewest.source.replace('_', ' ')} from {fewest.starts} of three start angles: "
            "an Fx error that turns with the wheel stays in it"
        )
    return "not told by the force: look at zero and gain of Fx"


def _relative(value: RadiusValue) -> float:
    error = value.measured.std_error
    return error / value.measured.value if math.isfinite(error) else 0.0


MORE = (
    lateral_table,
    stiffness_table,
    source_table,
    friction_table,
    transmission_table,
)
