# SPDX-License-Identifier: Apache-2.0
"""Results, figures and tables as one page that opens offline."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from importlib.resources import files
from typing import Any

from jinja2 import Environment

from flatplank_analysis.figures.spec import Figure
from flatplank_analysis.identify.mf.fit import MFFit
from flatplank_analysis.models.tire_record import TireRecord
from flatplank_analysis.report.radii import radius_values
from flatplank_analysis.report.results import CampaignResult
from flatplank_analysis.report.table import Table

LONG_TABLE = 30
"""rows from which a table is folded"""
FIGURE_WIDTH = 760

SECTIONS: Mapping[str, tuple[str, str]] = {
    "measurements": (
        "Measurements",
        "Signals over road displacement: interpolated to a common grid, averaged over the runs of "
        "a condition, low-passed without phase at 323 1/m (10 Hz at 30.92 mm/s).",
    ),
    "repeatability": ("Repeatability", ""),
    "models": (
        "Models beside measurements",
        "The linear transient model is fitted to every step by itself; the nonlinear model has "
        "one carcass stiffness for all steps of an operating point; MF-Tyre has one set of "
        "coefficients for the whole campaign, behind a constant relaxation length or at a contact "
        "point on the carcass spring (Pacejka 2012, section 7.2).",
    ),
    "waveforms": (
        "Other waveforms",
        "Runs whose slip is no step, with the linear model driven by the measured slip.",
    ),
    "special": (
        "Cleat, parking, turning, camber",
        "Measurements of one kind each, every run by itself beside its model.",
    ),
    "reference": (
        "Reference tire",
        "The same tire at the beginning of every session: does the machine measure today what it "
        "measured before?",
    ),
    "parameters": ("Parameters", ""),
    "radius": ("Effective rolling radius", ""),
    "machine": ("Tire at rest and machine", ""),
}
TABLES_OF = {
    "measurements": ("steps",),
    "models": ("rmse_linear", "rmse_nonlinear", "rmse_mf", "rmse_mf_contact_point", "rmse_floor"),
    "parameters": (
        "linear",
        "model_parameters",
        "carcass",
        "lateral",
        "magic_formula",
        "relative_error",
    ),
    "reference": ("reference",),
    "special": ("cleat", "parking", "turning", "camber_sweep"),
    "radius": ("rolling_radius", "radius_sources", "settling"),
    "machine": ("longitudinal_stiffness", "standing", "transmission", "friction_torque"),
}


def render(
    result: CampaignResult,
    figures: Mapping[str, Sequence[Figure]],
    pictures: Mapping[str, str],
    tables: Sequence[Table],
) -> str:
    """The page as text; `pictures` has the SVG element of every figure by name."""
    template = files("flatplank_analysis.report_files").joinpath("page.html.j2").read_text("utf-8")
    environment = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True)
    tire = f"{result.tire}: " if result.tire else ""
    return environment.from_string(template).render(
        title=f"{tire}flat plank measurements",
        subtitle=result.path,
        tire_record=result.record.headline() if result.record else "",
        sections=_sections(figures, pictures, tables),
        cards=_cards(result),
        statements=_statements(result),
        problems=[str(p) for p in result.problems],
        figure_width=FIGURE_WIDTH,
        footer="SI units, ISO W axes; driving slip is positive. Numbers after ± are one standard "
        "error. All figures and tables are beside this page as PNG, SVG, CSV and JSON.",
    )


def _sections(
    figures: Mapping[str, Sequence[Figure]],
    pictures: Mapping[str, str],
    tables: Sequence[Table],
) -> list[dict[str, Any]]:
    by_name = {t.name: t for t in tables}
    out = []
    for key, (title, lead) in SECTIONS.items():
        shown = [_figure(f, pictures[f.name]) for f in figures.get(key, ())]
        mine = [_table(by_name[n]) for n in TABLES_OF.get(key, ()) if n in by_name]
        if shown or mine:
            out.append(
                {"key": key, "title": title, "lead": lead, "figures": shown, "tables": mine}
            )
    return out


def _figure(figure: Figure, picture: str) -> dict[str, Any]:
    return {
        "name": figure.name,
        "title": figure.title,
        "caption": figure.caption,
        "source": figure.source,
        "wide": len(figure.panels) > 1 and not figure.stacked,
        "svg": picture,
    }


def _table(table: Table) -> dict[str, Any]:
    digits = [2 if name.startswith("±") else 4 for name in table.header]
    rows = [[_cell(c, d) for c, d in zip(row, digits, strict=True)] for row in table.rows]
    return {
        "name": table.name,
        "title": table.title,
        "header": table.header,
        "rows": rows,
        "note": table.note,
        "long": len(rows) > LONG_TABLE,
    }


def _cell(value: str | float, digits: int) -> str:
    if not isinstance(value, str):
        return number(value, digits)
    return value.replace("-", "−") if value[:1] == "-" else value


def number(value: float, digits: int = 4) -> str:
    """A number for people: so many digits, a true minus, a dash for NaN."""
    if not math.isfinite(value):
        return "–"
    if value == 0.0:
        return "0"
    if abs(value) < 10.0 ** (digits - 7):
        return f"{value:.{digits - 1}e}".replace("e-0", "e-").replace("-", "−")
    places = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    text = f"{value:.{min(places, 6)}f}"
    return text.replace("-", "−")


def _cards(result: CampaignResult) -> list[dict[str, str]]:
    runs = sum(len(c.names) for c in result.conditions)
    cards = []
    if runs:
        label = f"slip runs in {len(result.conditions)} conditions"
        cards.append({"value": str(runs), "label": label})
    if result.why_no_magic:
        cards.append({"value": "no Magic Formula", "label": result.why_no_magic})
    nominal = result.nominal()
    radii = [v for v in radius_values(result) if nominal and v.point == nominal.point]
    if radii:
        value = number(1e3 * radii[0].corrected.value)
        cards.append({"value": f"{value} mm", "label": "effective rolling radius at Fx = 0"})
    if nominal is not None:
        cards.append(_small_slip(nominal))
        if nominal.carcass is not None:
            c_cx = nominal.carcass.without_bias()["c_cx"]
            text = f"{number(1e-3 * c_cx.value)} ± {number(1e-3 * c_cx.std_error, 2)} kN/m"
            label = "carcass stiffness c_cx, without the model's bias"
            cards.append({"value": text, "label": label})
        for model in nominal.models.values():
            mean = sum(model.rmse.values()) / max(len(model.rmse), 1)
            cards.append({"value": f"{number(mean, 3)} N", "label": f"mean RMSE, {model.title}"})
    return cards


def _small_slip(nominal) -> dict[str, str]:
    known = [c for c in nominal.conditions if c.linear.sigma.determined]
    best = min(known, key=lambda c: (abs(c.condition.kappa), -c.condition.kappa), default=None)
    if best is None:
        return {"value": "–", "label": "no slip step to fit"}
    fit = best.linear
    text = f"{number(fit.sigma.value, 3)} ± {number(fit.sigma.std_error, 2)} m"
    return {"value": text, "label": f"σx at {100 * best.condition.kappa:+g} % slip"}


def _statements(result: CampaignResult) -> list[str]:
    """What fits say they cannot know, each once."""
    out: dict[str, None] = {}
    if result.record and result.tire and result.record.name != result.tire:
        out[f"The tire record is of {result.record.name}, the runs are of {result.tire}."] = None
    if result.why_no_magic:
        out[f"No Magic Formula: {result.why_no_magic}."] = None
    if result.magic is not None:
        out |= dict.fromkeys(_of_magic(result.magic, result.record))
    for confusion in result.magic.confusions if result.magic else ():
        out[f"Magic Formula: {confusion.statement}; {confusion.remedy}."] = None
    for point in result.points:
        where = point.point.label()
        if point.why_no_carcass:
            out[f"{where}: no carcass stiffness: {point.why_no_carcass}"] = None
        for confusion in point.carcass.confusions if point.carcass else ():
            out[f"{where}: {confusion.statement}; {confusion.remedy}."] = None
        for c in point.conditions:
            for confusion in c.linear.confusions:
                text = f"{c.condition.label()}: {confusion.statement}"
                out[f"{text} (correlation {confusion.correlation:.2f}); {confusion.remedy}."] = (
                    None
                )
    return list(out)


def _of_magic(fit: MFFit, record: TireRecord | None) -> list[str]:
    """What of the fitted tire is not from these data."""
    told = [f"MF-Tyre's C_x, and with it σx: {fit.cx_source}."]
    missing = [name for name in ("fx", "fy", "mz") if name not in fit.fits]
    if missing and record is not None:
        whose = record.start_file or "the general start values, which are those of no tire"
        outputs = ", ".join(name.capitalize() for name in missing)
        told.append(f"Magic Formula: {outputs} not fitted; fitted.tir has there {whose}.")
    return told
