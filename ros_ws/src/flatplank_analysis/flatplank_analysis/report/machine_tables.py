# SPDX-License-Identifier: Apache-2.0
"""Further tables: side force, stiffness at rest, wheel drive, and measurements without a slip
step.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from flatplank_analysis.identify.lateral import zero_warning
from flatplank_analysis.report.results import (
    CampaignResult,
    DriveRun,
    LateralResult,
    PointResult,
    RestRun,
)
from flatplank_analysis.report.table import Cell, Column, Table, estimate, number, point_table
from flatplank_analysis.starts import Value, value_over_starts
from flatplank_analysis.steady.transmission import (
    DriveState,
    FrictionTorque,
    efficiency,
    mean_state,
)
from flatplank_data.condition import Condition


class DriveMeans(NamedTuple):
    """Torques of one condition, mean over the start angles, and the efficiency that they give."""

    condition: Condition
    state: DriveState
    efficiency: Value


def drive_means(point: PointResult, friction: FrictionTorque | None) -> list[DriveMeans]:
    """A row per slip of a point, in increasing order."""
    groups: dict[Condition, list[DriveRun]] = {}
    for run in point.further.drive:
        groups.setdefault(run.condition, []).append(run)
    out = []
    for condition in sorted(groups, key=lambda c: c.kappa):
        states = [run.state for run in groups[condition]]
        starts = [run.start for run in groups[condition]]
        found = efficiency(states, starts, friction)
        out.append(DriveMeans(condition, mean_state(states, starts), found))
    return out


def friction_of(result: CampaignResult) -> FrictionTorque | None:
    """Friction torque M_F over motor speed, from the unloaded turns; None without them."""
    return result.extras.get("friction_torque")


def friction_table(result: CampaignResult) -> Table:
    """Figure 5.3 as numbers."""
    curve = friction_of(result)
    rows = [] if curve is None else np.column_stack([curve.speed, curve.torque, curve.scatter])
    return Table(
        "friction_torque",
        "Friction of the wheel drive",
        ("motor speed [rad/s]", "friction torque [N m]", "± of a sample [N m]"),
        [list(map(float, r)) for r in rows],
        "Motor torque of unloaded turns, mean per speed.",
    )


def transmission_table(result: CampaignResult) -> Table:
    """Figures 5.4 and 5.13 as numbers."""
    curve = friction_of(result)
    rows = [(means.condition, means) for p in result.points for means in drive_means(p, curve)]
    rows.sort(key=lambda row: row[0].sort_key)

    def friction(means: DriveMeans) -> float:
        return curve(means.state.motor_velocity) if curve else math.nan

    columns = (
        ("κ [%]", lambda m: f"{100.0 * m.condition.kappa:.10g}"),
        ("M_M [N m]", lambda m: m.state.motor_torque),
        ("M_T / i [N m]", lambda m: m.state.tire_torque),
        ("M_F [N m]", friction),
        ("η [%]", lambda m: 100.0 * m.efficiency.value),
        ("± [%]", lambda m: 100.0 * m.efficiency.std_error),
        ("runs", lambda m: str(m.efficiency.runs)),
    )
    lack = "" if curve else " No unloaded turn was measured: without M_F there is no efficiency."
    note = (
        "Over the last half metre, mean over the start angles; η = M_T / (M_M − M_F) (5.3) of the "
        "means of driving runs: the slewing drive locks itself, so a braking tire takes no motor "
        f"torque.{lack}"
    )
    title = "Wheel drive: torque and efficiency"
    return point_table("transmission", title, rows, columns, note)


def stiffness_table(result: CampaignResult) -> Table:
    """Longitudinal stiffness of the standing tire and of the rolling one."""
    found = [(p.point, (_at_rest(result, p), rolling_stiffness(p))) for p in result.points]
    rows = [(point, it) for point, it in found if it[0].runs or math.isfinite(it[1])]
    columns = (
        ("C_x at rest [kN/m]", lambda r: 1e-3 * r[0].value),
        ("± [kN/m]", lambda r: 1e-3 * r[0].std_error),
        ("runs", lambda r: str(r[0].runs)),
        ("C_x rolling [kN/m]", lambda r: 1e-3 * r[1]),
        ("rest / rolling", lambda r: r[0].value / r[1]),
    )
    note = (
        "At rest: the road moves and the wheel is held, while Fx is small. "
        "Rolling: C_Fκ / σx by (7.27). Play between road and plank makes the first one too small."
    )
    title = "Longitudinal stiffness"
    return point_table("longitudinal_stiffness", title, rows, columns, note)


def _at_rest(result: CampaignResult, point: PointResult) -> Value:
    """C_x of slip runs that began with a locked wheel, and of standing runs at this point."""
    c = point.point
    here = (c.fz, c.pressure, c.gamma_deg)
    standing = [
        RestRun(r["value"], r["start"])
        for r in result.extras.get("standing", [])
        if r["quantity"] == "C_x" and (r["fz"], r["pressure"], r["gamma_deg"]) == here
    ]
    runs = [*point.further.rest_stiffness, *([] if c.alpha_deg else standing)]
    return value_over_starts([run.value for run in runs], [run.start for run in runs])


def standing_table(result: CampaignResult) -> Table:
    """Results of the standing tire: vertical stiffness, C_x, C_y, friction, run by run."""
    rows: list[list[Cell]] = []
    for r in result.extras.get("vertical_stiffness", []):
        parts = f"loading {1e-3 * r['loading']:.4g}, unloading {1e-3 * r['unloading']:.4g} kN/m"
        rows.append([r["run"], "-", f"{r['pressure']:g}", "C_z", 1e-3 * r["mean"], "kN/m", parts])
    for r in result.extras.get("standing", []):
        unit, factor = ("-", 1.0) if r["quantity"] == "μ" else ("kN/m", 1e-3)
        cells = [r["name"], f"{r['fz']:g}", f"{r['pressure']:g}", r["quantity"]]
        rows.append([*cells, factor * r["value"], unit, ""])
    header = ("run", "Fz [N]", "p [bar]", "quantity", "value", "unit", "remark")
    note = (
        "Slopes of the force over the travel before the tire slides; friction of a locked wheel."
    )
    return Table("standing", "Standing tire (Appendix G)", header, rows, note)


def rolling_stiffness(point: PointResult) -> float:
    """C_x = C_Fk / sigma_x (7.7) of the carcass fit [N/m], NaN without one."""
    fit = point.carcass
    return math.nan if fit is None else fit.rolling_stiffness


@dataclass(frozen=True)
class LateralRow:
    """A lateral transient and the half contact length of its point [m]."""

    found: LateralResult
    a: float
    warning: str = ""
    """Warning where the measured angles do not determine the steering zero."""

    @property
    def spring(self) -> float:
        """c_cy by (7.27) in y with sigma_c = a [N/m]; NaN when the run does not determine it."""
        fit = self.found.fit
        known = fit.settled and fit.sigma.determined and fit.slip_stiffness.determined
        beyond = fit.sigma.value - self.a
        return fit.slip_stiffness.value / beyond if known and beyond > 0.0 else math.nan

    @property
    def remark(self) -> str:
        """Reservations about these numbers."""
        fit = self.found.fit
        notes = [e.note for e in (fit.sigma, fit.slip_stiffness) if not e.determined]
        notes += [] if fit.settled else ["not settled: the asymptote is an extrapolation"]
        return "; ".join(dict.fromkeys(filter(None, [*notes, self.warning])))


def lateral_table(result: CampaignResult) -> Table:
    """Side force from the start of rolling."""
    columns = (
        (
            "σy [m]",
            lambda r: r.found.fit.sigma.value if r.found.fit.sigma.determined else math.nan,
        ),
        ("± [m]", lambda r: r.found.std_error[0]),
        ("C′Fα [kN/rad]", lambda r: 1e-3 * r.found.fit.slip_stiffness.value),
        ("± [kN/rad]", lambda r: 1e-3 * r.found.std_error[1] / abs(r.found.fit.kappa)),
        ("Fy,ss [N]", lambda r: -r.found.fit.steady_force.value),
        ("± [N]", lambda r: r.found.std_error[1]),
        ("c_cy [kN/m]", lambda r: 1e-3 * r.spring),
        ("runs", lambda r: str(r.found.runs)),
        ("settled", lambda r: "yes" if r.found.fit.settled else "no"),
        ("remark", lambda r: r.remark),
    )
    note = (
        "The slip angle is set before the road moves: its step is the start. Linear model of Fy "
        "over tan α up to the slip step, mean of the runs, by itself at every angle. c_cy by "
        "(7.27) in y with σ_c = a; `flatplank fit --model lateral` takes all angles together and, "
        "from runs at +α and −α, finds the steering zero."
    )
    angles: dict[Condition, list[float]] = {}
    for p in result.points:
        if p.further.lateral is not None:
            other = p.point._replace(alpha_deg=math.nan)
            angles.setdefault(other, []).append(p.point.alpha_deg)
    rows = [
        (
            p.point,
            LateralRow(
                p.further.lateral,
                result.geometry.half_length(p.point.fz, p.point.pressure),
                zero_warning(angles[p.point._replace(alpha_deg=math.nan)]),
            ),
        )
        for p in result.points
        if p.further.lateral is not None
    ]
    return point_table("lateral", "Lateral transient", rows, columns, note)


def _kind_table(
    kind: str, title: str, columns: Sequence[list[Column]], note: str
) -> Callable[[CampaignResult], Table]:
    def make(result: CampaignResult) -> Table:
        rows = [(r["condition"], r["found"]) for r in result.extras.get(kind, [])]
        return point_table(kind, title, rows, [c for group in columns for c in group], note)

    return make


KINDS_TABLES = (
    _kind_table(
        "cleat",
        "Cleat",
        (
            number("height [mm]", "height", 1e3),
            number("ΔFz [N]", "rise"),
            number("ΔFz / height [kN/m]", "stiffness_over_cleat", 1e-3),
            number("dFx/dx at the middle [kN/m]", "fx_slope", 1e-3),
            estimate("Cz of the model", "kN/m", "stiffness", 1e-3),
            estimate("cam radius", "mm", "cam_radius", 1e3),
            estimate("cam distance", "mm", "cam_distance", 1e3),
            number("RMSE Fz [N]", "rmse_fz"),
            number("RMSE Fx [N]", "rmse_fx"),
        ),
        "At a fixed axle. The effective road has the height (Fz − Fz,0)/Cz and the slope "
        "−(Fx − Fx,0)/Fz; the model is two round cams that follow the true profile (Schmeitz "
        "2004). A cleat whose record does not say its length counts as 10 mm long.",
    ),
    _kind_table(
        "parking",
        "Parking",
        (
            estimate("C", "N m/rad", "stiffness"),
            estimate("M_max", "N m", "saturation"),
            estimate("c", "-", "exponent"),
            number("largest |Mz| [N m]", "largest"),
            number("|Mz| at 0° [N m]", "residual_moment"),
            number("work per cycle [J]", "loss"),
            number("RMSE [N m]", "rmse"),
        ),
        "Standing tire. C: slope of Mz over the steering angle where a turn begins; M_max: moment "
        "of the sliding patch; c: how late it begins to slide (van der Jagt 2000, reversals by "
        "Masing's rule).",
    ),
    _kind_table(
        "turning",
        "Impulse turning",
        (
            estimate("C_Fα", "kN/rad", "cornering_stiffness", 1e-3),
            estimate("σy", "m", "relaxation_length"),
            estimate("a", "mm", "half_length", 1e3),
            estimate("remaining angle", "mrad", "remaining_angle", 1e3),
            number("RMSE Fy [N]", "rmse"),
            number("RMSE Mz [N m]", "rmse_moment"),
        ),
        "Linear brush of half length a on a lateral carcass spring, Fy and Mz together. Where a "
        "part of the patch slides C_Fα is that of the impulse's size, below that at zero slip. "
        "Remaining angle: what is left of the turn below the resolution of the steering encoder.",
    ),
    _kind_table(
        "camber_sweep",
        "Camber sweep",
        (
            estimate("C_Fγ", "kN/rad", "camber_stiffness", 1e-3),
            estimate("σγ", "m", "relaxation_length"),
            estimate("share without lag", "%", "direct_share", 1e2),
            estimate("C_Mγ", "N m/rad", "moment_stiffness"),
            number("RMSE Fy [N]", "rmse"),
        ),
        "C_Fγ = −dFy/dγ and C_Mγ = dMz/dγ of the steady tire, one relaxation length for both, and "
        "the share of Fy that follows the camber without lag.",
    ),
)

MACHINE_TABLES = (
    lateral_table,
    stiffness_table,
    standing_table,
    friction_table,
    transmission_table,
)
