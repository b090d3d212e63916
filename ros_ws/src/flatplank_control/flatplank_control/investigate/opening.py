# SPDX-License-Identifier: Apache-2.0
"""An investigation in a folder: its loop, begun or gone on with, and what it leaves there."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery import verdict
from flatplank_analysis.discovery.report.page import write_report
from flatplank_analysis.discovery.verdict import Diagnosis
from flatplank_analysis.investigation.loop import Loop, Say
from flatplank_analysis.investigation.notebook import text_of
from flatplank_analysis.investigation.report import DIAGNOSIS, write_notebook
from flatplank_analysis.proposal.propose import PROPOSED, of_diagnosis
from flatplank_control.investigate.bench import REPORT, CampaignBench, Execute
from flatplank_control.investigate.journal import DiskLog
from flatplank_control.runner.campaign.tires import TireEntry, known_tires
from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError
from flatplank_data.files import write_atomic
from flatplank_data.params import nearest

NOTEBOOK = "investigation.txt"


def open_loop(
    folder: Path,
    minutes: float,
    execute: Execute,
    tire: str = "",
    effects: tuple[str, ...] = (),
    say: Say = lambda _: None,
) -> Loop:
    """The loop of a folder, with what its log has."""
    bench = CampaignBench(folder, tire_of(tire, folder), execute, effects)

    def at_end(session: Session, result: Diagnosis) -> dict[str, Any] | None:
        if result.search is not None:
            write_report(result, folder / REPORT / DIAGNOSIS, str(folder))
        return proposed(session, result, folder)

    return Loop(bench, DiskLog(folder), minutes, say, at_end=at_end)


def keep(loop: Loop, folder: Path) -> Path:
    """The notebook as text and as a page, which is returned."""
    write_atomic(folder / NOTEBOOK, text_of(loop.log.events) + "\n")
    return write_notebook(loop.log.events, folder / REPORT, str(folder))


def tire_of(name: str, folder: Path) -> TireEntry:
    """As named, else as the runs of the folder say, else the first one that is known."""
    known = known_tires()
    if not name and (folder / "campaign.yaml").exists():
        name = Campaign.load(folder).tire
    name = name or next(iter(known))
    if name not in known:
        raise FlatplankError(
            f"unknown tire '{name}'{nearest(name, known)}", str(folder), "name it: --tire"
        )
    return known[name]


def proposed(session: Session, result: Diagnosis, folder: Path) -> dict[str, Any] | None:
    """What the grammar of effects says to what no library explains, and its file."""
    if result.verdict not in (verdict.NONE, verdict.PARTLY):
        return None
    made = of_diagnosis(session, result)
    if made.verdict != PROPOSED or made.sentence is None:
        return {"verdict": made.verdict, "reason": made.reason}
    path = folder / f"{made.name}.py"
    if not path.exists():  # somebody may have changed it by hand
        write_atomic(path, made.text)
    return {"verdict": made.verdict, "reason": made.sentence.words(), "file": str(path)}
