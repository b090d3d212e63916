# SPDX-License-Identifier: Apache-2.0
"""Tables of chapters 6 and 7: steps, models and their parameters."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from flatplank_analysis.discovery.floor import BELOW
from flatplank_analysis.identify.results import Estimate
from flatplank_analysis.report.machine_tables import KINDS_TABLES, MACHINE_TABLES
from flatplank_analysis.report.radii import radius_table, source_table
from flatplank_analysis.report.results import CampaignResult, ConditionResult
from flatplank_analysis.report.table import (
    Cell,
    Table,
    error_of,
    estimate,
    point_table,
    remark_of,
    value_of,
)
from flatplank_analysis.steady.stiffness import friction


def all_tables(result: CampaignResult) -> list[Table]:
    """All tables with content, in the order of the report."""
    tables = [step_table(result), linear_table(result), *rmse_tables(result)]
    makers = (
        geometry_table, carcass_table, magic_table, relative_error_table, radius_table,
        settling_table, *KINDS_TABLES, reference_table, *MACHINE_TABLES, source_table,
    )  # fmt: skip
    tables += [make(result) for make in makers]
    return [t for t in tables if len(t.rows)]


def step_table(result: CampaignResult) -> Table:
    """Table 6.3: slip, load and road speed of the steps as measured."""
    columns = (
        ("κ desired [%]", lambda c: f"{100.0 * c.condition.kappa:.10g}"),
        ("κ before [%]", lambda c: 100.0 * c.facts.kappa_before),
        ("κ actual [%]", lambda c: 100.0 * c.facts.kappa_actual),
        ("ΔFz [%]", lambda c: 100.0 * c.facts.load_change),
        ("V before [mm/s]", lambda c: 1e3 * c.facts.speed_before),
        ("V after [mm/s]", lambda c: 1e3 * c.facts.speed_after),
        ("runs", lambda c: str(len(c.names))),
        ("cycles lost", lambda c: str(c.cycles_lost)),
        ("largest std of Fx [N]", lambda c: c.max_scatter()),
        ("settled", lambda c: "yes" if c.linear.settled else "no"),
    )
    rows = [(c.condition, c) for c in result.conditions]
    note = "Slip from turned angle and travelled road; the standard deviation is over the runs."
    return point_table("steps", "Steps as they were (Table 6.3)", rows, columns, note)


def linear_table(result: CampaignResult) -> Table:
    """Figure 7.3 and Table 7.1 as numbers."""
    columns = (
        ("κ [%]", lambda c: f"{100.0 * c.condition.kappa:.10g}"),
        *estimate("σx", "m", "linear.sigma"),
        *estimate("C′Fκ", "kN", "linear.slip_stiffness", 1e-3),
        *estimate("Fx,ss", "N", "linear.steady_force"),
        ("corr(σ, F)", lambda c: c.linear.correlation),
        ("RMSE [N]", lambda c: c.linear.rmse_transient),
        ("remark", _linear_remark),
    )
    note = (
        "Linear transient model (7.11) of the mean of the runs. The asymptote is fitted together "
        "with σx; ± is one standard error with autocorrelated noise. RMSE over the transient part."
    )
    rows = [(c.condition, c) for c in result.conditions]
    return point_table("linear", "Linear transient model (Table 7.1)", rows, columns, note)


def _linear_remark(c: ConditionResult) -> str:
    remark = remark_of(c.linear.sigma, c.linear.slip_stiffness, c.linear.steady_force)
    late = "" if c.linear.settled else "not settled: the asymptote is an extrapolation"
    return "; ".join(text for text in (remark, late) if text)


def rmse_tables(result: CampaignResult) -> list[Table]:
    """Tables 7.1, 7.3, 7.4 and Appendix H: RMSE per slip and operating point, one per model.

    The last one is the floor, the error of the measured mean itself.
    """
    levels = sorted({c.condition.kappa for c in result.conditions})
    columns = [
        (f"{100 * k:+g} %" if k else "0 %", lambda errors, k=k: errors.get(k, math.nan))
        for k in levels
    ]
    note = "Over the transient part of the mean response; at 0 % slip all that follows the step."
    titles = {name: m.title for p in reversed(result.points) for name, m in p.models.items()}
    out = []
    for name in dict.fromkeys(name for p in result.points for name in p.models):
        rows = [
            (p.point, {c.kappa: value for c, value in p.models[name].rmse.items()})
            for p in result.points
            if name in p.models
        ]
        title = f"RMSE [N]: {titles[name]}"
        out.append(point_table(f"rmse_{name}", title, rows, columns, note))
    floors = [
        (p.point, {c.condition.kappa: c.floor() for c in p.conditions}) for p in result.points
    ]
    known = [(p, f) for p, f in floors if any(math.isfinite(v) for v in f.values())]
    note = (
        "Scatter of single runs over the square root of their number, over the transient part: "
        "the error that the measured mean has itself. What turns with the wheel cancels in the "
        f"mean of the start angles and is no part of it. And {BELOW}."
    )
    title = "Floor of the models' errors [N]"
    return [*out, point_table("rmse_floor", title, known, columns, note)]


def geometry_table(result: CampaignResult) -> Table:
    """Table 7.2: parameters of the nonlinear model beside the carcass stiffness."""
    fits = [p.carcass for p in result.points if p.carcass is not None]
    if not fits:
        return Table("model_parameters", "", (), ())
    g, c = result.geometry, result.geometry.contact
    deep = [
        s
        for s in result.conditions
        if not s.condition.alpha_deg and not s.condition.gamma_deg
        if math.isclose(abs(s.condition.kappa), 0.1, abs_tol=1e-6)
    ]
    mu = friction([s.linear.steady_force.value for s in deep], [s.facts.fz_after for s in deep])
    rows: list[list[Cell]] = [
        ["m_c", 1.0, "kg", "not fitted: quasi-static, as if there were none"],
        ["r_0", c.free_radius, "m", g.source("free_radius")],
        ["μ", mu, "-", "mean |Fx,ss|/Fz at ±10 % (the fits: largest of their point)"],
        ["q_ra1", c.q_ra1, "-", g.source("q_ra1")],
        ["q_ra2", c.q_ra2, "-", g.source("q_ra2")],
        ["C_z0", c.vertical_stiffness, "N/m", g.source("vertical_stiffness")],
        ["p_Fz1", c.pressure_effect, "-", g.source("pressure_effect")],
    ]
    nominal = result.nominal()
    if nominal is not None and nominal.carcass is not None:
        fit = nominal.carcass
        tied = fit.slip_stiffness.value / (2.0 * fit.half_length**2)
        rows.append(["c_px", tied, "N/m²", "tied: C_Fκ = 2a² c_px at the nominal point"])
    note = "At the nominal pressure. What was not measured is the tire record's."
    title = "Parameters of the nonlinear model (Table 7.2)"
    return Table("model_parameters", title, ("parameter", "value", "unit", "from"), rows, note)


def carcass_table(result: CampaignResult) -> Table:
    """Figures 7.24, 7.25 as numbers."""
    columns = (
        *estimate("c_cx", "kN/m", "c_cx", 1e-3),
        ("CFκ [kN]", lambda f: 1e-3 * value_of(f.slip_stiffness)),
        *estimate("σx (7.27)", "m", "sigma_x"),
        ("a [mm]", lambda f: 1e3 * f.half_length),
        ("model's bias of c_cx [%]", lambda f: 100.0 * f.model_bias["c_cx"]),
        ("of σx [%]", lambda f: 100.0 * f.model_bias["sigma_x"]),
        ("c_cx without it [kN/m]", lambda f: 1e-3 * value_of(f.without_bias()["c_cx"])),
        ("± of that [kN/m]", lambda f: 1e-3 * error_of(f.without_bias()["c_cx"])),
        ("σx without it [m]", lambda f: value_of(f.without_bias()["sigma_x"])),
        ("± of that [m]", lambda f: error_of(f.without_bias()["sigma_x"])),
        ("at bound", lambda f: f.c_cx.at_bound or "no"),
        ("remark", lambda f: remark_of(f.c_cx, f.slip_stiffness, f.sigma_x)),
    )
    note = (
        "Nonlinear contact patch model, one carcass stiffness per operating point (7.25, 7.26). "
        "The model's own bias is what it finds too much on a tread of bristles at small slip. "
        "In ± of c_cx and σx is half of what driving and braking steps disagree."
    )
    rows = [(p.point, p.carcass) for p in result.points if p.carcass is not None]
    return point_table("carcass", "Carcass stiffness", rows, columns, note)


def magic_table(result: CampaignResult) -> Table:
    """Table I.1 with standard errors, and coefficients that are not determined."""
    fitted: Sequence[Estimate] = list(result.magic.estimates.values()) if result.magic else ()
    rows: list[list[Cell]] = [[e.name, e.text, error_of(e), e.unit, remark_of(e)] for e in fitted]
    note = (
        "Fitted in stages, then jointly per output; fitted.tir beside this page has them all. In "
        "parentheses: not determined by these runs, near its start value."
    )
    header = ("coefficient", "value", "±", "unit", "remark")
    return Table("magic_formula", "Magic Formula (Table I.1)", header, rows, note)


def relative_error_table(result: CampaignResult) -> Table:
    """Relative error (7.28) of the Magic Formula per output."""
    errors = result.magic.relative_errors if result.magic else {}
    rows: list[list[Cell]] = [[name, 100.0 * value] for name, value in errors.items()]
    note = "Over the steady points that the coefficients were fitted to."
    return Table("relative_error", "Relative error (7.28)", ("output", "e_r [%]"), rows, note)


def settling_table(result: CampaignResult) -> Table:
    """Free-rolling runs: settling distance (Appendix E) and steady error."""
    rows: list[list[Cell]] = []
    for r in result.extras.get("free_rolling", []):
        held = math.isfinite(r["reference"])
        distance, error = r["settling_distance"], 100.0 * r["steady_error"]
        steady = [r["fit"].p3 if held else math.nan, r["steady_force"]]
        remark = _settling_remark(r) if held else "flexplates off: no controller, no reference"
        rows.append([r["run"], r["fz"], r["reference"], distance, *steady, error, remark])
    header = (
        "run", "Fz [N]", "reference [N]", "settling distance [m]", "asymptote p3 [N]",
        "steady Fx [N]", "steady error [%]", "remark",
    )  # fmt: skip
    note = (
        "Within 5 % of the controller's reference by the exponential fit (E.1); steady force and "
        "its error over the last 1.5 m."
    )
    return Table("settling", "Free rolling", header, rows, note)


def _settling_remark(run: Mapping[str, Any]) -> str:
    notes = [run["fit"].remark]
    notes += [] if math.isfinite(run["settling_distance"]) else ["does not settle within 5 %"]
    return "; ".join(filter(None, notes))


def reference_table(result: CampaignResult) -> Table:
    """Control charts as numbers."""
    header = (
        "quantity", "bench", "unit", "sessions", "runs", "mean", "± limit", "repeatability",
        "reproducibility", "remark",
    )  # fmt: skip
    rows: list[list[Cell]] = []
    for c in result.extras.get("sessions", []):
        counts = [str(len(c.means)), str(int(c.runs.sum()))]
        numbers = [c.centre, c.reach, c.repeatability, c.reproducibility]
        rows.append([c.title, c.bench, c.unit, *counts, *numbers, "; ".join(c.remarks)])
    note = (
        "Standard deviations within a session (repeatability) and between sessions beyond that "
        "(reproducibility); limits of an individuals chart, 3 x mean moving range / 1.128."
    )
    return Table("reference", "Reference tire over the sessions", header, rows, note)
