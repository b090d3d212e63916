# SPDX-License-Identifier: Apache-2.0
"""Writes a report: report.html, report.json, figures/ (PNG, SVG, CSV), tables/ (CSV)."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from flatplank_analysis.models.tir import write_tir
from flatplank_analysis.report.analysis import Progress, analyse
from flatplank_analysis.report.results import CampaignResult
from flatplank_analysis.report.sessions import Session, charts_of, session_of
from flatplank_analysis.report.tire import record_for
from flatplank_data.campaign import Campaign
from flatplank_data.files import write_atomic

PAGE = "report.html"


def build(
    campaign: str | os.PathLike[str] | Campaign,
    out_dir: str | os.PathLike[str],
    *,
    jobs: int | None = 1,
    scheduler: str | None = None,
    progress: Progress | None = None,
    tire: str | os.PathLike[str] | None = None,
    reference: Sequence[Campaign] = (),
) -> Path:
    """Analyse a campaign folder and write its report; returns the page.

    `tire`: a tire record. `reference`: sessions of the reference tire, for control charts.
    """
    if not isinstance(campaign, Campaign):
        campaign = Campaign.load(campaign)
    record = record_for([campaign], tire)
    result = analyse(campaign, jobs=jobs, scheduler=scheduler, progress=progress, tire=record)
    if reference:
        charts = charts_of([_session(c, jobs, scheduler) for c in reference])
        result = replace(result, extras={**result.extras, "sessions": charts})
    return write(result, out_dir)


def _session(campaign: Campaign, jobs: int | None, scheduler: str | None) -> Session:
    found = analyse(campaign, jobs=jobs, scheduler=scheduler, nonlinear=False, magic=False)
    return session_of(campaign, found)


def write(result: CampaignResult, out_dir: str | os.PathLike[str]) -> Path:
    """Write the report of results; returns the page."""
    # matplotlib and jinja2 load here, so that a fit does not wait for them
    from flatplank_analysis.figures.draw import save
    from flatplank_analysis.figures.registry import make_figures
    from flatplank_analysis.report.tables import all_tables
    from flatplank_analysis.report_files.page import render

    out = Path(out_dir)
    out.mkdir(parents=True, exist_ok=True)
    figures = make_figures(result)
    tables = all_tables(result)
    every = [figure for group in figures.values() for figure in group]
    pictures = {figure.name: save(figure, out / "figures") for figure in every}
    (out / "tables").mkdir(exist_ok=True)
    for table in tables:
        write_atomic(out / "tables" / f"{table.name}.csv", table.csv(), durable=False)
    if result.magic is not None:
        write_tir(result.magic.file, out / "fitted.tir")
    write_atomic(out / "report.json", json.dumps(result.to_json(), indent=1), durable=False)
    write_atomic(out / PAGE, render(result, figures, pictures, tables), durable=False)
    return out / PAGE
