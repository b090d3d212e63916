# SPDX-License-Identifier: Apache-2.0
"""Fit a tire model; every number with its standard error."""

from __future__ import annotations

import argparse
import dataclasses
import math
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from flatplank_analysis.cli import common
from flatplank_analysis.identify.campaign import (
    FITTERS,
    ConditionFits,
    FitFile,
    carcass_fits,
    fit_campaign,
    read_fit_file,
)
from flatplank_analysis.identify.carcass import CarcassFit
from flatplank_analysis.identify.mf.fit import MFFit
from flatplank_analysis.identify.mf.stages import general_start
from flatplank_analysis.identify.repeats import LinearCondition
from flatplank_analysis.identify.results import Estimate, to_plain
from flatplank_analysis.models.tire_record import TireRecord, start_tir
from flatplank_analysis.parallel import open_executor
from flatplank_analysis.report.steps import extra_points, read_group, read_lateral, read_steps
from flatplank_analysis.report.tire import geometry_of_campaigns, record_for, tires_of
from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError
from flatplank_data.wording import plain
from flatplank_tire.tir import write_tir

FORMAT = "flatplank-fit/1"
READERS = {"lateral": read_lateral}
"""model -> how its runs are read, `read_group` for the others"""
CARCASS = ("nonlinear", "lateral", "mf")
GEOMETRY = ("free_radius", "vertical_stiffness", "pressure_effect", "q_ra1", "q_ra2")


def main(argv: Sequence[str] | None = None) -> int:
    """`flatplank fit DIR... --model linear|nonlinear|lateral|mf [--json]`."""
    parser = common.campaign_parser("fit", __doc__, several=True)
    parser.add_argument("--model", choices=sorted(FITTERS), help="default: linear")
    parser.add_argument("--settings", metavar="FILE", help="fit file: free, fixed, bounds, prior")
    parser.add_argument("--stage", action="append", help="mf: this stage only (again for more)")
    common.tire_argument(parser)
    parser.add_argument("--out", metavar="FILE.tir", help="mf: write the fitted tire")
    common.parallel_arguments(parser)
    arguments = parser.parse_args(argv)
    return common.run_or_report_nothing_usable("fit", lambda: _run(arguments))


def _run(arguments: argparse.Namespace) -> int:
    begin = time.perf_counter()
    settings = _settings(arguments)
    campaigns = _campaigns(arguments, settings)
    record = record_for(campaigns, settings.tire or None)
    with open_executor(arguments.jobs, arguments.scheduler) as executor:
        steps, radii = read_steps(campaigns, executor, READERS.get(settings.model, read_group))
        settings, facts = _with_geometry(settings, campaigns, record)
        start, extra = None, []
        if settings.model == "mf":
            if len(names := tires_of(campaigns)) > 1:
                what = f"runs of {len(names)} tires ({', '.join(names)})"
                remedy = "fit the folders of one tire at a time"
                raise FlatplankError(what, "Magic Formula", remedy)
            start = start_tir(record, general_start())
            fits = carcass_fits(steps, settings, executor.map)
            extra = extra_points(campaigns, steps, radii, fits, record)
        result = fit_campaign(steps, settings, extra=extra, start=start, mapper=executor.map)
    problems = [p for campaign in campaigns for p in campaign.problems]
    common.print_problems(problems)
    if arguments.out:
        if not isinstance(result, MFFit):
            raise FlatplankError("this model has no .tir", "--out", "use --model mf")
        write_tir(result.file, arguments.out)
    if arguments.json:
        head = {
            "format": FORMAT,
            "model": settings.model,
            "campaigns": [c.path for c in campaigns],
            "runs": len(steps),
            "tire_record": to_plain(record),
        } | ({"geometry": facts} if facts else {})
        found = {k: v for k, v in result.to_json().items() if k not in ("model", "problems")}
        troubles = [str(p) for p in problems] + list(getattr(result, "problems", ()))
        tail = {"problems": troubles, "seconds": round(time.perf_counter() - begin, 3)}
        common.print_json(head | found | tail)
    else:
        print(f"tire {record.headline()}")
        SHOW[type(result)](result)
        _say([f"{k} = {v['value']:.5g}: {v['source']}" for k, v in facts.items()])
    return 0


def _with_geometry(
    settings: FitFile, campaigns: Sequence[Campaign], record: TireRecord
) -> tuple[FitFile, dict[str, dict[str, Any]]]:
    """Settings with the contact geometry of carcass fits, and value and source of each number.

    The fit file overrides measurements, and these override the tire record.
    """
    if settings.model not in CARCASS:
        return settings, {}
    found = geometry_of_campaigns(campaigns, record)
    numbers = dataclasses.asdict(found.contact) | dict(settings.geometry)
    facts = {
        k: {"value": v, "source": "fit file" if k in settings.geometry else found.source(k)}
        for k, v in numbers.items()
        if k in GEOMETRY
    }
    return dataclasses.replace(settings, geometry=numbers), facts


def _settings(arguments: argparse.Namespace) -> FitFile:
    """The fit file, overridden by the command line."""
    base = read_fit_file(arguments.settings) if arguments.settings else FitFile()
    stages = tuple(arguments.stage or ())
    said = {"model": arguments.model, "stages": stages, "tire": arguments.tire}
    return dataclasses.replace(base, **{k: v for k, v in said.items() if v})


def _campaigns(arguments: argparse.Namespace, settings: FitFile) -> list[Campaign]:
    folders = list(arguments.folder)
    if not folders and arguments.settings:
        here = Path(arguments.settings).parent
        folders = [str(here / name) for name in settings.campaigns]
    if not folders:
        raise FlatplankError("no campaign", "command line", "name a folder")
    return [common.load_folder(folder, arguments.mapping) for folder in folders]


def _conditions(result: ConditionFits) -> None:
    rows = [row for fit in result.fits for row in ROWS[type(fit)](fit)]
    common.print_rows(("condition", "slip", "parameter", "value", "±", "unit", "remark"), rows)
    statements = [c for fit in result.fits for c in fit.confusions]
    _say([f"{c.statement}; {c.remedy}" for c in statements])
    for text in result.problems:
        print(f"warning: {text}", file=sys.stderr)


def _linear_rows(fit: LinearCondition) -> list[tuple[str, ...]]:
    name = fit.operating_point.label()
    return [
        _row(name, f"{100.0 * level.level:+g} %", estimate)
        for level in fit.levels
        for estimate in (level.sigma, level.slip_stiffness, level.steady_force)
    ]


def _carcass_rows(fit: CarcassFit) -> list[tuple[str, ...]]:
    return [_row(fit.operating_point.label(), "", e, _bias(fit, e)) for e in fit.estimates]


def _bias(fit: CarcassFit, e: Estimate) -> str:
    """Remark on the model's own bias in an estimate; empty where there is none."""
    if not e.determined or e.name not in fit.model_bias:
        return ""
    share, free = 100.0 * fit.model_bias[e.name], fit.without_bias()[e.name]
    low, high = free.interval()
    interval = f"{free.value:.5g} without it (90 %: {low:.5g} to {high:.5g})"
    return f"the model's own bias on bristles {share:+.1f} %: {interval}"


def _row(condition: str, slip: str, e: Estimate, beside: str = "") -> tuple[str, ...]:
    if not e.determined:
        remark = e.note or "not determined"
    else:
        notes = "; ".join(filter(None, (e.note, beside)))
        remark = f"at its {e.at_bound} bound" if e.at_bound else notes
    error = plain(e.std_error, 2) if e.determined and math.isfinite(e.std_error) else "-"
    return (condition, slip, e.name, e.text, error, e.unit, remark)


def print_coefficients(result: MFFit) -> None:
    """The fitted coefficients, the errors of the outputs, and what the data do not determine."""
    rows = [_row("", "", e)[2:] for e in result.estimates.values()]
    common.print_rows(("parameter", "value", "±", "unit", "remark"), rows)
    errors = ", ".join(f"{k} {100.0 * v:.2g} %" for k, v in result.relative_errors.items())
    print(f"\nrelative error (7.28): {errors}")
    _say([f"{c.statement}; {c.remedy}" for c in result.confusions])


def _magic_formula(result: MFFit) -> None:
    print_coefficients(result)
    _say([f"C_x {result.cx_source}", *(f"not fitted: {text}" for text in result.skipped)])


def _say(lines: Sequence[str]) -> None:
    for line in dict.fromkeys(lines):
        print(f"note: {line}")


ROWS: dict[type, Callable[[Any], list[tuple[str, ...]]]] = {
    LinearCondition: _linear_rows,
    CarcassFit: _carcass_rows,
}
SHOW: dict[type, Callable[[Any], None]] = {ConditionFits: _conditions, MFFit: _magic_formula}
