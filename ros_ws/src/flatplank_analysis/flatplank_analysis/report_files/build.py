# SPDX-License-Identifier: Apache-2.0
"""Writes a report: report.html, which opens offline, report.json, figures/ (PNG, SVG, CSV) and
tables/ (CSV).
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from flatplank_analysis.figures import chapter6, chapter7, machine, magic, other
from flatplank_analysis.figures.draw import save
from flatplank_analysis.figures.spec import Figure
from flatplank_analysis.pages.book import Book, Picture, write_page
from flatplank_analysis.report.analysis import Progress, analyse
from flatplank_analysis.report.radii import radius_values
from flatplank_analysis.report.results import CampaignResult
from flatplank_analysis.report.sessions import charts_of, session_of
from flatplank_analysis.report.table import Cell, Table
from flatplank_analysis.report.tables import all_tables
from flatplank_analysis.report.tire import record_for
from flatplank_data.campaign import Campaign
from flatplank_data.files import write_atomic
from flatplank_tire.tir import write_tir

PAGE = "report.html"
MOST_PLACES = 6
"""decimal places of a number without a unit, at most"""
PLACES = {
    "%": 2, "N": 2, "kN": 4, "N m": 3, "mm": 3, "mm/s": 2, "m": 5, "kN/m": 3, "°": 3, "bar": 3,
}  # fmt: skip
"""decimal places of a unit, at most: what is finer no instrument of the bench shows"""


def build(
    campaign: Campaign,
    out_dir: str | os.PathLike[str],
    *,
    jobs: int | None = 1,
    scheduler: str | None = None,
    progress: Progress | None = None,
    tire: str | os.PathLike[str] | None = None,
    reference: Sequence[Campaign] = (),
) -> Path:
    """Analyse a campaign and write its report; returns the page.

    `tire`: a tire record. `reference`: sessions of the reference tire, for control charts.
    """
    record = record_for([campaign], tire)
    result = analyse(campaign, jobs=jobs, scheduler=scheduler, progress=progress, tire=record)
    if reference:
        less = partial(analyse, jobs=jobs, scheduler=scheduler, nonlinear=False, magic=False)
        charts = charts_of([session_of(c, less(c)) for c in reference])
        result = replace(result, extras={**result.extras, "sessions": charts})
    return write(result, out_dir)


def write(result: CampaignResult, out_dir: str | os.PathLike[str]) -> Path:
    """Write the report of results; returns the page."""
    out = Path(out_dir)
    out.mkdir(parents=True, exist_ok=True)
    figures = make_figures(result)
    tables = all_tables(result)
    every = [figure for group in figures.values() for figure in group]
    book = Book(out, "figures")
    pictures = {figure.name: save(book, figure) for figure in every}
    (out / "tables").mkdir(exist_ok=True)
    for table in tables:
        write_atomic(out / "tables" / f"{table.name}.csv", table.csv(), durable=False)
    if result.magic is not None:
        write_tir(result.magic.file, out / "fitted.tir")
    write_atomic(out / "report.json", json.dumps(result.to_json(), indent=1), durable=False)
    return _write_page(out / PAGE, result, figures, pictures, tables)


LONG_TABLE = 30
"""rows from which a table is folded"""


class Section(NamedTuple):
    """A part of the page; figures and tables without data are left out."""

    title: str
    lead: str
    makers: Sequence[Callable[[CampaignResult], Iterable[Figure]]]
    """results -> figures, none without data"""
    tables: Sequence[str]
    """names of tables"""


SECTIONS = {
    "measurements": Section(
        "Measurements",
        "Signals over road displacement: interpolated to a common grid, averaged over the runs of "
        "a condition, low-passed without phase shift at 323 1/m (10 Hz at 30.92 mm/s).",
        (chapter6.nominal_forces, chapter6.road_speed, chapter6.varied_forces,
         chapter6.crossed_forces),
        ("steps",),
    ),
    "repeatability": Section("Repeatability", "", (chapter6.repeatability,), ()),
    "models": Section(
        "Models beside measurements",
        "The linear transient model is fitted to every step by itself; the nonlinear model has "
        "one carcass stiffness for all steps of an operating point; MF-Tyre has one set of "
        "coefficients for the whole campaign, behind a constant relaxation length or at a contact "
        "point on the carcass spring (Pacejka 2012, section 7.2).",
        (chapter7.errors_beside_floor, chapter7.overlays),
        ("rmse_linear", "rmse_nonlinear", "rmse_mf", "rmse_mf_contact_point", "rmse_floor"),
    ),
    "waveforms": Section(
        "Other waveforms",
        "Runs whose slip is no step, with the linear model driven by the measured slip.",
        (other.waveforms, other.frequency),
        (),
    ),
    "special": Section(
        "Cleat, parking, turning, camber",
        "Measurements of one kind each, every run by itself beside its model.",
        (other.cleats, other.parkings, other.over_travel),
        ("cleat", "parking", "turning", "camber_sweep"),
    ),
    "reference": Section(
        "Reference tire",
        "The same tire at the beginning of every session: does the machine measure today what it "
        "measured before?",
        (other.control_charts,),
        ("reference",),
    ),
    "parameters": Section(
        "Parameters",
        "",
        (
            chapter7.lateral_starts, magic.magic_lateral, chapter7.linear_parameters,
            chapter7.parameters_over_factor, chapter7.steady_curves, chapter7.crossed_angles,
            magic.magic_curves,
            chapter7.carcass,
        ),
        ("linear", "model_parameters", "carcass", "lateral", "magic_formula", "relative_error"),
    ),
    "radius": Section(
        "Effective rolling radius",
        "",
        (
            magic.modelled_radius_angles, machine.rolling_radius, magic.modelled_radius,
            machine.settling,
        ),
        ("rolling_radius", "radius_sources", "settling"),
    ),
    "machine": Section(
        "Tire at rest and machine",
        "",
        (machine.transmission, machine.vertical, machine.contact_length, machine.friction),
        ("longitudinal_stiffness", "standing", "transmission", "friction_torque"),
    ),
}  # fmt: skip


def make_figures(result: CampaignResult) -> dict[str, list[Figure]]:
    """All figures that the results allow, by section."""
    made = {
        key: [figure for make in section.makers for figure in make(result)]
        for key, section in SECTIONS.items()
    }
    return {key: figures for key, figures in made.items() if figures}


def _write_page(
    page: Path,
    result: CampaignResult,
    figures: Mapping[str, Sequence[Figure]],
    pictures: Mapping[str, Picture],
    tables: Sequence[Table],
) -> Path:
    """Write the page with `pictures` by name; returns it."""
    statements = dict.fromkeys(_statements(result))
    problems = [str(p) for p in result.problems]
    sections = list(_sections(figures, tables))
    parts = [(section["key"], section["title"]) for section in sections]
    parts += [("limits", "What the data cannot tell")] * bool(statements)
    parts += [("problems", "Problems of the files")] * bool(problems)
    tire = f"{result.tire}: " if result.tire else ""
    return write_page(
        page,
        "report.html.j2",
        Path(__file__).parent,
        title=f"{tire}flat plank measurements",
        subtitle=result.path,
        tire_record=result.record.headline() if result.record else "",
        parts=parts,
        sections=sections,
        pictures=pictures,
        long_table=LONG_TABLE,
        cards=_cards(result),
        statements=statements,
        problems=problems,
        about=result.about,
    )


def _sections(
    figures: Mapping[str, Sequence[Figure]], tables: Sequence[Table]
) -> Iterator[dict[str, Any]]:
    """Sections with content; tables have their cells as text."""
    cells = {t.name: (t, _cells(t)) for t in tables}
    for key, section in SECTIONS.items():
        mine = [cells[name] for name in section.tables if name in cells]
        if key in figures or mine:
            said = {"key": key, "title": section.title, "lead": section.lead}
            yield said | {"figures": figures.get(key, ()), "tables": mine}


def _cells(table: Table) -> list[list[str]]:
    columns = [_column(*column) for column in zip(table.header, *table.rows, strict=True)]
    return [list(row) for row in zip(*columns, strict=True)]


def _column(name: str, *cells: Cell) -> list[str]:
    """The cells of a column as text; its numbers end where people stop to read that unit."""
    digits = 2 if name.startswith("±") else 4
    unit = name.rpartition("[")[2].rstrip("]")
    return [number(cell, digits, PLACES.get(unit, MOST_PLACES)) for cell in cells]


def number(value: str | float, digits: int = 4, places: int = MOST_PLACES) -> str:
    """A number as text with these digits, at most so many decimal places, and a minus sign; a
    dash for NaN; a text as it is.

    A text that begins with a hyphen gets a minus sign.
    """
    if isinstance(value, str):
        return value.replace("-", "−") if value[:1] == "-" else value
    if not math.isfinite(value):
        return "–"
    if value == 0.0:
        return "0"
    wanted = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    text = f"{value:.{min(wanted, places)}f}"
    return (text if float(text) else text.lstrip("-")).replace("-", "−")


def _cards(result: CampaignResult) -> Iterator[tuple[str, str]]:
    """Key results for the top of the page, each with its label."""
    runs = sum(len(c.names) for c in result.conditions)
    if runs:
        yield str(runs), f"slip runs in {len(result.conditions)} conditions"
    if result.why_no_magic:
        yield "no Magic Formula", result.why_no_magic
    nominal = result.nominal()
    radii = [v for v in radius_values(result) if nominal and v.point == nominal.point]
    if radii:
        yield f"{number(1e3 * radii[0].corrected.value)} mm", "effective rolling radius at Fx = 0"
    if nominal is None:
        return
    known = [c for c in nominal.conditions if c.linear.sigma.determined]
    best = min(known, key=lambda c: (abs(c.condition.kappa), -c.condition.kappa), default=None)
    if best is None:
        yield "–", "no slip step to fit"
    else:
        sigma = best.linear.sigma
        value = f"{number(sigma.value, 3)} ± {number(sigma.std_error, 2)} m"
        yield value, f"σx at {100 * best.condition.kappa:+g} % slip"
    if nominal.carcass is not None:
        c_cx = nominal.carcass.without_bias()["c_cx"]
        value = f"{number(1e-3 * c_cx.value)} ± {number(1e-3 * c_cx.std_error, 2)} kN/m"
        yield value, "carcass stiffness c_cx, without the model's bias"
    for model in nominal.models.values():
        mean = sum(model.rmse.values()) / max(len(model.rmse), 1)
        yield f"{number(mean, 3)} N", f"mean RMSE, {model.title}"


def _statements(result: CampaignResult) -> Iterator[str]:
    """Statements of the fits on undetermined parameters."""
    record, magic = result.record, result.magic
    if record and result.tire and record.name != result.tire:
        yield f"The tire record is of {record.name}, the runs are of {result.tire}."
    if result.why_no_magic:
        yield f"No Magic Formula: {result.why_no_magic}."
    if magic is not None:
        yield f"MF-Tyre's C_x, and with it σx: {magic.cx_source}."
        missing = [name for name in ("fx", "fy", "mz") if name not in magic.fits]
        if missing and record is not None:
            whose = record.start_file or "the general start values, which are those of no tire"
            outputs = ", ".join(name.capitalize() for name in missing)
            yield f"Magic Formula: {outputs} not fitted; fitted.tir has there {whose}."
        for confusion in magic.confusions:
            yield f"Magic Formula: {confusion.statement}; {confusion.remedy}."
    for point in result.points:
        where = point.point.label()
        if point.why_no_carcass:
            yield f"{where}: no carcass stiffness: {point.why_no_carcass}"
        for confusion in point.carcass.confusions if point.carcass else ():
            yield f"{where}: {confusion.statement}; {confusion.remedy}."
        for c in point.conditions:
            for confusion in c.linear.confusions:
                how = f"{confusion.statement} (correlation {confusion.correlation:.2f})"
                yield f"{c.condition.label()}: {how}; {confusion.remedy}."
