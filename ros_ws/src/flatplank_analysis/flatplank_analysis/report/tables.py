# SPDX-License-Identifier: Apache-2.0
"""Tables of the thesis for any campaign; also as CSV."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from dataclasses import dataclass

from flatplank_analysis.data.info import Condition
from flatplank_analysis.report.results import CampaignResult
from flatplank_analysis.report.steps import slip_stiffness
from flatplank_analysis.steady.value import Value, mean_value


@dataclass(frozen=True)
class Table:
    """Rows of texts and numbers under a header."""

    name: str
    title: str
    header: Sequence[str]
    rows: Sequence[Sequence[str | float]]
    note: str = ""

    def csv(self) -> str:
        """All digits."""
        stream = io.StringIO()
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(self.header)
        for row in self.rows:
            writer.writerow([f"{c:.10g}" if isinstance(c, float) else c for c in row])
        return stream.getvalue()


@dataclass(frozen=True)
class RadiusValue:
    """r_e of one operating point from one source."""

    point: Condition
    source: str
    measured: Value
    """as (5.22) gives it [m]"""
    corrected: Value
    """at Fx = 0 [m]"""
    force: float
    """mean Fx during it [N]"""
    slip_stiffness: float = math.nan
    """with which it was corrected [N]"""
    starts: int = 1
    """different start angles"""


def radius_values(result: CampaignResult) -> list[RadiusValue]:
    """r_e by operating point and source; corrected with the slip stiffness of that point."""
    groups: dict[tuple[Condition, str], list] = {}
    for run in result.radii:
        point = run.condition.operating_point._replace(measurement="slip")
        groups.setdefault((point, run.source), []).append(run)
    stiffness = {p.point: slip_stiffness(p) for p in result.points}
    known = [v for v in stiffness.values() if math.isfinite(v)]
    out = []
    for (point, source), runs in groups.items():
        c = stiffness.get(point, math.nan)
        if not math.isfinite(c) and known:
            c = sum(known) / len(known)
        corrected = [r.corrected(c) if math.isfinite(c) else r.radius for r in runs]
        force = mean_value(_per_start([r.force for r in runs], [r.start for r in runs])).value
        note = "" if math.isfinite(c) else "not corrected: no slip stiffness"
        angles = [r.start for r in runs]
        measured = mean_value(_per_start([r.radius for r in runs], angles))
        known_c = mean_value(_per_start(corrected, angles), note)
        starts = len({r.start for r in runs})
        out.append(RadiusValue(point, source, measured, known_c, force, c, starts))
    return out


def _per_start(values: Sequence[float], starts: Sequence[int]) -> list[float]:
    """Values, or the means of the start angles where these have different numbers of runs."""
    groups: dict[int, list[float]] = {}
    for value, start in zip(values, starts, strict=True):
        groups.setdefault(start, []).append(value)
    if len({len(g) for g in groups.values()}) < 2:
        return list(values)
    return [sum(g) / len(g) for g in groups.values()]


def all_tables(result: CampaignResult) -> list[Table]:
    """What there is to tell, in the order of the report."""
    tables = [step_table(result), linear_table(result), *rmse_tables(result)]
    tables += [carcass_table(result), magic_table(result), relative_error_table(result)]
    tables += [radius_table(result), settling_table(result)]
    # they use what stands here
    from flatplank_analysis.report.more_tables import MORE

    tables += [make(result) for make in MORE]
    return [t for t in tables if len(t.rows)]


def point_cells(point: Condition) -> list[str | float]:
    """The operating point as the first cells of a row."""
    values = (point.fz, point.pressure, point.alpha_deg, point.gamma_deg)
    return [f"{v:.10g}" for v in values]


POINT_COLUMNS = ("Fz [N]", "p [bar]", "α [°]", "γ [°]")


def step_table(result: CampaignResult) -> Table:
    """Table 6.3."""
    rows = [
        [
            *point_cells(c.condition),
            f"{100.0 * c.condition.kappa:.10g}",
            100.0 * c.facts.kappa_before,
            100.0 * c.facts.kappa_actual,
            100.0 * c.facts.load_change,
            1e3 * c.facts.speed_before,
            1e3 * c.facts.speed_after,
            str(len(c.names)),
            c.max_scatter(),
            "yes" if c.linear.settled else "no",
        ]
        for c in result.conditions
    ]
    header = (
        *POINT_COLUMNS,
        "κ desired [%]",
        "κ before [%]",
        "κ actual [%]",
        "ΔFz [%]",
        "V before [mm/s]",
        "V after [mm/s]",
        "runs",
        "largest std of Fx [N]",
        "settled",
    )
    note = "Slip from turned angle and travelled road; the standard deviation is over the runs."
    return Table("steps", "Steps as they were (Table 6.3)", header, rows, note)


def linear_table(result: CampaignResult) -> Table:
    """Figure 7.3 and Table 7.1 as numbers."""
    rows = []
    for c in result.conditions:
        fit = c.linear
        rows.append(
            [
                *point_cells(c.condition),
                f"{100.0 * c.condition.kappa:.10g}",
                fit.sigma.value,
                fit.sigma.std_error,
                1e-3 * fit.slip_stiffness.value,
                1e-3 * fit.slip_stiffness.std_error,
                fit.steady_force.value,
                fit.steady_force.std_error,
                fit.correlation,
                fit.rmse_transient,
            ]
        )
    header = (
        *POINT_COLUMNS,
        "κ [%]",
        "σx [m]",
        "± [m]",
        "C′Fκ [kN]",
        "± [kN]",
        "Fx,ss [N]",
        "± [N]",
        "corr(σ, F)",
        "RMSE [N]",
    )
    note = (
        "Linear transient model (7.11) of the mean of the runs. The asymptote is fitted together "
        "with σx; ± is one standard error with autocorrelated noise. RMSE over the transient part."
    )
    return Table("linear", "Linear transient model (Table 7.1)", header, rows, note)


def rmse_tables(result: CampaignResult) -> list[Table]:
    """Tables 7.1, 7.3, 7.4 and Appendix H: RMSE per slip and operating point, one per model."""
    names = list(dict.fromkeys(name for p in result.points for name in p.models))
    levels = sorted({c.condition.kappa for c in result.conditions})
    out = []
    for name in names:
        rows = []
        for point in result.points:
            model = point.models.get(name)
            if model is None:
                continue
            errors = {c.kappa: value for c, value in model.rmse.items()}
            rows.append([*point_cells(point.point), *(errors.get(k, math.nan) for k in levels)])
        header = (*POINT_COLUMNS, *(f"{100 * k:+g} %" if k else "0 %" for k in levels))
        title = f"RMSE of the {name} model [N]"
        note = "Over the transient part of the mean response; at κ = 0 all that follows the step."
        out.append(Table(f"rmse_{name}", title, header, rows, note))
    return out


def carcass_table(result: CampaignResult) -> Table:
    """Figures 7.24, 7.25 as numbers."""
    rows = []
    for point in result.points:
        fit = point.carcass
        if fit is None:
            continue
        rows.append(
            [
                *point_cells(point.point),
                1e-3 * fit.c_cx.value,
                1e-3 * fit.c_cx.std_error,
                1e-3 * fit.slip_stiffness.value,
                fit.sigma_x.value,
                fit.sigma_x.std_error,
                1e3 * fit.half_length,
                100.0 * fit.model_bias["c_cx"],
                100.0 * fit.model_bias["sigma_x"],
                1e-3 * fit.without_bias()["c_cx"],
                fit.without_bias()["sigma_x"],
                fit.c_cx.at_bound or "no",
            ]
        )
    header = (
        *POINT_COLUMNS,
        "c_cx [kN/m]",
        "± [kN/m]",
        "CFκ [kN]",
        "σx (7.27) [m]",
        "± [m]",
        "a [mm]",
        "model's bias of c_cx [%]",
        "of σx [%]",
        "c_cx without it [kN/m]",
        "σx without it [m]",
        "at bound",
    )
    note = (
        "Nonlinear contact patch model, one carcass stiffness per operating point (7.25, 7.26). "
        "The model's own bias is what it finds too much on a tread of bristles at small slip."
    )
    return Table("carcass", "Carcass stiffness", header, rows, note)


def magic_table(result: CampaignResult) -> Table:
    """Table I.1 with standard errors and what is not determined."""
    fit = result.magic
    rows = []
    for e in fit.estimates.values() if fit else ():
        remark = "" if e.determined else (e.note or "not determined")
        if e.at_bound and e.determined:
            remark = f"at its {e.at_bound} bound"
        rows.append([e.name, e.value, e.std_error, remark])
    note = "Fitted in stages, then jointly per output; fitted.tir beside this page has them all."
    header = ("coefficient", "value", "±", "remark")
    return Table("magic_formula", "Magic Formula (Table I.1)", header, rows, note)


def relative_error_table(result: CampaignResult) -> Table:
    """Relative error (7.28) of the Magic Formula per output."""
    errors = result.magic.relative_errors if result.magic else {}
    rows = [[name, 100.0 * value] for name, value in errors.items()]
    note = "Over the steady points that the coefficients were fitted to."
    return Table("relative_error", "Relative error (7.28)", ("output", "e_r [%]"), rows, note)


def radius_table(result: CampaignResult) -> Table:
    """Figures 6.1, 6.2 as numbers, sources side by side."""
    rows = [
        [
            *point_cells(v.point),
            v.source.replace("_", " "),
            1e3 * v.measured.value,
            1e3 * v.measured.std_error,
            v.force,
            1e3 * v.corrected.value,
            str(v.measured.runs),
        ]
        for v in radius_values(result)
    ]
    header = (
        *POINT_COLUMNS,
        "source",
        "r_e [mm]",
        "± [mm]",
        "Fx [N]",
        "r_e at Fx = 0 [mm]",
        "runs",
    )
    note = "By (5.22). A force F makes a slip F/C_Fκ: r_e at Fx = 0 is r_e (1 + F/C_Fκ)."
    return Table("rolling_radius", "Effective rolling radius", header, rows, note)


def settling_table(result: CampaignResult) -> Table:
    """Free-rolling runs: settling distance (Appendix E) and steady error."""
    rows = [
        [r["run"], r["fz"], r["settling_distance"], r["p3"], 100.0 * r["steady_error"]]
        for r in result.extras.get("free_rolling", [])
    ]
    header = ("run", "Fz [N]", "settling distance [m]", "asymptote p3 [N]", "steady error [%]")
    note = "Within 5 % of 50 N by the exponential fit (E.1); error over the last 1.5 m."
    return Table("settling", "Free-rolling controller", header, rows, note)
