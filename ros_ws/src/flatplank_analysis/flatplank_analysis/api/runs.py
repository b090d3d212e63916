# SPDX-License-Identifier: Apache-2.0
"""A campaign as a pandas table of runs, the samples of a run as a DataFrame with units, the
report, and the HTML that a notebook shows.
"""

from __future__ import annotations

import base64
import dataclasses
import os
import warnings
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import pandas as pd

from flatplank_analysis.cli.common import read_mapping
from flatplank_data.campaign import Campaign
from flatplank_data.campaign import Run as CampaignRun
from flatplank_data.condition import is_nan
from flatplank_data.errors import FlatplankError
from flatplank_data.problem import Problem
from flatplank_data.run_record import OF_THE_RECORDING, UNITS, RunRecord
from flatplank_data.table import MeasurementTable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RUN = "run"
"""column of a table of runs with the run objects"""
SHOWN = ("name", "condition", "kappa", "fz", "pressure", "alpha_deg", "gamma_deg", "start")
"""columns of every table of runs, beside those with a value in some run"""


class Run:
    """One run of a table of runs; `table` reads its samples, `info` is its record."""

    def __init__(self, campaign: Campaign, run: CampaignRun) -> None:
        self.campaign, self.source = campaign, run

    @property
    def info(self) -> RunRecord:
        """The run record."""
        return self.source.info

    @property
    def measured(self) -> MeasurementTable:
        """The samples as the verbs use them."""
        return self.source.table()

    @property
    def table(self) -> pd.DataFrame:
        """The samples in SI, read from the file; `attrs["units"]` has the unit of each column."""
        measured = self.measured
        frame = pd.DataFrame(dict(measured.columns))
        frame.attrs = {"run": self.info.file, "units": measured.units}
        return frame

    def __repr__(self) -> str:
        return self.info.name


def load(
    folder: str | os.PathLike[str], mapping: str | Mapping[str, Any] | None = None
) -> pd.DataFrame:
    """The runs of a campaign folder, one per row; column `run` has the run objects.

    mapping: foreign topics or columns, as a dictionary or a YAML file. Unusable runs become
    warnings. `attrs["units"]` has the units of the columns.
    """
    given = mapping if isinstance(mapping, Mapping) else read_mapping(mapping)
    campaign = Campaign.load(folder, mapping=given)
    warn(campaign.problems)
    rows = [_row(campaign, run) for run in campaign.runs]
    said = {k for k in rows[0] if k in SHOWN or any(_has_value(row[k], k) for row in rows)}
    frame = pd.DataFrame([{k: v for k, v in row.items() if k in said} for row in rows])
    frame.attrs = {"units": {k: UNITS[k] for k in frame if k in UNITS}}
    return frame


def _row(campaign: Campaign, run: CampaignRun) -> dict[str, Any]:
    info = run.info
    head = {RUN: Run(campaign, run), "name": info.name, "condition": info.condition.label()}
    return head | {f.name: getattr(info, f.name) for f in _FIELDS}


_LEFT_OUT = OF_THE_RECORDING | {"file", "extra"}
_FIELDS = [f for f in dataclasses.fields(RunRecord) if f.name not in _LEFT_OUT]
_DEFAULTS = {f.name: f.default for f in _FIELDS}


def _has_value(value: Any, key: str) -> bool:
    """False for a default, NaN among them."""
    return key not in _DEFAULTS or (value != _DEFAULTS[key] and not is_nan(value))


def campaign_of(runs: pd.DataFrame) -> Campaign:
    """The campaign of a table of runs, which may be a selection or several tables joined."""
    if not isinstance(runs, pd.DataFrame) or RUN not in runs:
        raise FlatplankError(
            f"{type(runs).__name__} is no table of runs", "runs", 'make one by load("FOLDER")'
        )
    own: Sequence[Run] = list(dict.fromkeys(runs[RUN]))
    if not own:
        raise FlatplankError("no run is left", "runs", "keep some of the rows")
    folders = list({id(r.campaign): r.campaign for r in own}.values())
    path = "+".join(campaign.path for campaign in folders)
    return Campaign(path, [r.source for r in own], folders[0].tire)


def same_runs(campaign: Campaign, runs: pd.DataFrame) -> bool:
    """True when a campaign consists of exactly these runs."""
    other = campaign_of(runs).runs
    return [id(r) for r in campaign.runs] == [id(r) for r in other]


def warn(problems: Iterable[Problem]) -> None:
    """Issue problems as warnings of Python, one line each."""
    for problem in problems:
        warnings.warn(str(problem), stacklevel=3)


def write_report(
    runs: pd.DataFrame, folder: str | os.PathLike[str], tire: str | os.PathLike[str] | None = None
) -> Path:
    """Write the page of `flatplank report` with its figures and tables; return the page.

    tire: a tire record; None: `tire.yaml` of the campaign, or made from the data.
    """
    from flatplank_analysis.report_files.build import build

    campaign = campaign_of(runs)
    page = build(campaign, folder, tire=tire)
    warn(campaign.problems)
    return page


Plot = TypeVar("Plot")


def figure_of(known: Mapping[str, Plot], name: str) -> Plot:
    """The figure of that name; FlatplankError lists the existing ones."""
    if name not in known:
        raise FlatplankError(f"no figure '{name}'", "plot", f"known: {', '.join(known)}")
    return known[name]


def page(text: str, tables: Iterable[pd.DataFrame] = (), figures: Iterable[Figure] = ()) -> str:
    """Self-contained HTML of a result."""
    from flatplank_analysis.discovery.report.figures import png

    parts = [f"<pre>{escape(text)}</pre>"]
    parts += [table.to_html(index=False, border=0) for table in tables if len(table)]
    for figure in figures:
        data = base64.b64encode(png(figure)).decode("ascii")
        parts.append(f'<img alt="figure" src="data:image/png;base64,{data}">')
    return "\n".join(parts)
