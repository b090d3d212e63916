# SPDX-License-Identifier: Apache-2.0
"""The reference tire and its page: control charts over the days and benches of a catalogue."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from flatplank_analysis.catalogues.catalogue import Catalogue
from flatplank_analysis.parallel import open_executor
from flatplank_analysis.report.analysis import Progress, analyse
from flatplank_analysis.report.results import CampaignResult
from flatplank_analysis.report.sessions import Session, charts_of, session_of
from flatplank_analysis.report_files.build import write
from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError, NothingUsableError
from flatplank_data.problem import Problem


def write_chart(
    runs: Catalogue,
    folder: str | os.PathLike[str],
    *,
    jobs: int | None = 1,
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> Path:
    """Write the page of the selected runs; returns the page. Raises as `charted`."""
    return write(charted(runs, jobs=jobs, scheduler=scheduler, progress=progress), folder)


def charted(
    runs: Catalogue,
    *,
    jobs: int | None = 1,
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> CampaignResult:
    """The control charts of the selected runs, a session per campaign folder.

    Raises FlatplankError for runs of several tires, and without a quantity in two sessions.
    """
    tires = sorted({t for t in runs.table["tire"].to_pylist() if t})
    if len(tires) != 1:
        named = ", ".join(tires) or "no tire"
        what = f"a control chart is of one tire, and these runs are of {named}"
        raise FlatplankError(what, str(runs.root), "select it: tire=NAME")
    campaigns = list(runs.campaigns())
    sessions: list[Session] = []
    problems: list[Problem] = []
    with open_executor(jobs, scheduler) as executor:
        for done, (found, told) in enumerate(executor.map(_session, campaigns), start=1):
            sessions += found
            problems += told
            if progress:
                progress(done, len(campaigns), Path(campaigns[done - 1].path).name)
    extras = {"sessions": charts_of(sessions)}
    return CampaignResult(str(runs.root), tires[0], [], problems, extras)


def _session(campaign: Campaign) -> tuple[list[Session], Sequence[Problem]]:
    """The session of a campaign, none where no run could be used; and its problems."""
    try:
        result = analyse(campaign, nonlinear=False, magic=False)
    except NothingUsableError:
        return [], campaign.problems
    return [session_of(campaign, result)], campaign.problems
