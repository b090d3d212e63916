# SPDX-License-Identifier: Apache-2.0
"""Diagnosis of what a model lacks: text and figures."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from flatplank_analysis.api.model import Model, open_session
from flatplank_analysis.api.runs import figure_of, page, same_runs
from flatplank_analysis.cli import loop
from flatplank_analysis.discovery import verdict
from flatplank_analysis.discovery.report.text import text_of
from flatplank_analysis.effects import consent
from flatplank_data.errors import FlatplankError

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def diagnose(
    runs: pd.DataFrame,
    model: Model | None = None,
    effects: Sequence[str | os.PathLike[str]] = (),
    measured: Mapping[str, Mapping[str, float]] | None = None,
    trust: Sequence[str | os.PathLike[str]] = (),
) -> Diagnosed:
    """Search for what a model lacks; `model`: by default the tire without effects.

    effects: your own effect files in addition to the library; measured: start values [SI] by
    effect and parameter, as a calibration gives them; trust: Python effect files that may run as
    they are now.
    """
    consent.give(trust)
    effects = (*effects, *trust)
    files = [*(os.fspath(e) for e in effects), *(model.session.files if model else ())]
    if model and same_runs(model.session.campaign, runs) and not effects:
        session = model.session
    else:
        session = open_session(runs, files)
    start = model.start if model else None
    result = session.diagnose(start, loop.progress, measured)
    loop.progress_done()
    history = start.history if start else ()
    return Diagnosed(result, session.campaign.path, history, session.about)


class Diagnosed:
    """A verdict with all its details; `print` shows what the command prints."""

    def __init__(
        self,
        result: verdict.Diagnosis,
        campaign: str,
        history: Sequence[Mapping[str, Any]],
        about: str = "",
    ) -> None:
        self.result, self.campaign, self._history, self._about = result, campaign, history, about

    @property
    def verdict(self) -> str:
        """One of: found, found group, partly, tire law only, none of these, at floor,
        not decidable."""
        return self.result.verdict

    @property
    def effects(self) -> pd.DataFrame:
        """Found effects: name, size, unit, interval, indistinguishable names, p-value."""
        nested = ("members", "text", "parameters")
        effects = self.to_dict()["effects"]
        return pd.DataFrame([{k: v for k, v in e.items() if k not in nested} for e in effects])

    @property
    def conditions(self) -> pd.DataFrame:
        """Error and floor of every condition, in the unit of the first channel."""
        return pd.DataFrame(self.to_dict()["conditions"])

    @property
    def to_do(self) -> pd.DataFrame:
        """What to do next, the first thing first; a row for every member of a class."""
        rows = [
            {"order": i, "do": task["do"], **one}
            for i, task in enumerate(self.to_dict()["to_do"], 1)
            for one in task["each"] or [{"name": "", "text": ""}]
        ]
        return pd.DataFrame(rows)

    @property
    def next_run(self) -> dict[str, Any]:
        """The most informative next run; empty when none helps."""
        return self.result.next_run

    def to_dict(self) -> dict[str, Any]:
        """The JSON of `flatplank diagnose`."""
        return self.result.to_dict()

    def plot(self, what: str = "conditions") -> Figure:
        """A figure: `conditions`, `ranking`, `residual`, `waterfall`, or an effect's name."""
        from flatplank_analysis.discovery.report import figures
        from flatplank_analysis.discovery.report.page import waterfall_steps

        search = self.result.drawable(self.campaign)
        drawn = {
            "conditions": lambda: figures.conditions(search.steps),
            "ranking": lambda: figures.ranking(search),
            "residual": lambda: figures.residual(search.last),
            "waterfall": lambda: figures.waterfall(
                waterfall_steps(search, self._history), self.result.floor, search.model.runs
            ),
        }
        for i, found in enumerate(self.result.found):
            name = found.decision.term.effect.identifier
            drawn[name] = partial(figures.collapse, search, i)
        return figure_of(drawn, what)()

    def report(self, folder: str | os.PathLike[str]) -> Path:
        """Write the page of `flatplank diagnose --report`; return it."""
        from flatplank_analysis.discovery.report.page import write_report

        return write_report(self.result, Path(folder), self.campaign, self._history, self._about)

    def __repr__(self) -> str:
        return text_of(self.result, self.campaign)

    def _repr_html_(self) -> str:
        drawn = [self.plot("conditions"), self.plot("ranking")] if self.result.search else []
        return page(repr(self), figures=drawn)


def script(main: Callable[..., Any], *arguments: Any) -> None:
    """Run a function as a program: bad data gives one line and exit code 1."""
    try:
        main(*arguments)
    except FlatplankError as error:
        sys.exit(str(error))
    except KeyError as error:
        sys.exit(f"the data have no {error}")
