# SPDX-License-Identifier: Apache-2.0
"""Opens an investigation in a folder: its log, the maker of its batches, loop and results."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery import verdict
from flatplank_analysis.discovery.report.page import write_report
from flatplank_analysis.discovery.verdict import Diagnosis
from flatplank_analysis.effects.grammar import file as proposal_file
from flatplank_analysis.investigation.loop import Loop, Say
from flatplank_analysis.investigation.notebook import text_of
from flatplank_analysis.investigation.report import DIAGNOSIS, write_notebook
from flatplank_analysis.pages.provenance import provenance
from flatplank_analysis.proposal.propose import PROPOSED, propose_from_diagnosis
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.bench.simulator import simulator
from flatplank_control.calibration.book import book_for
from flatplank_control.investigate.bench import REPORT, CampaignBench, Execute, campaign_so_far
from flatplank_control.runner.campaign import CampaignPlan, Conductor, Journal
from flatplank_control.runner.campaign.journal import write_line
from flatplank_control.runner.campaign.tires import TireEntry, known_tires
from flatplank_control.runner.steps import PlanFailed
from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError
from flatplank_data.files import write_atomic
from flatplank_data.journals import SUFFIX, read_lines
from flatplank_data.names import nearest_hint

NAME = "investigation.jsonl"
FORMAT = "flatplank-investigation/1"


class DiskLog:
    """Log of the events of `flatplank_analysis.investigation.loop`; starts or continues a file."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / NAME
        lines = read_lines(self.path)
        if lines and lines[0].get("format") != FORMAT:
            raise FlatplankError(
                f"is not of format {FORMAT}", str(self.path), "move it away, or choose another"
            )
        folder.mkdir(parents=True, exist_ok=True)
        self.events: list[dict[str, Any]] = lines

    def write(self, event: Mapping[str, Any]) -> None:
        """Append an event."""
        line = dict(event) if self.events else {"format": FORMAT, **event}
        write_line(self.path, line)
        self.events.append(line)


def conductor_of(folder: Path, plan: CampaignPlan) -> Conductor:
    """Conductor with the state of a batch."""
    return Conductor(plan, Journal(folder / f"{plan.name}{SUFFIX}", plan.name, plan.digest))


def executor_on_twin(
    folder: Path, preset: str, plant: str, seed: int, jobs: int | None, say: Callable[[str], None]
) -> Execute:
    """Make every batch on the twin, with the same plant."""
    setup = BenchSetup(
        preset=preset, plant_file=plant, seed=seed, pace="hold",
        calibration=str(book_for(folder).path),
    )  # fmt: skip

    def execute(plan: CampaignPlan, _text: str, left: float) -> None:
        conductor = conductor_of(folder, plan)
        several = min(jobs or os.cpu_count() or 1, max(conductor.total - conductor.done, 1))

        def progress(_conductor, _job, outcome) -> None:
            say(f"{outcome.file}: {outcome.text()}; {left:.0f} min left after this batch")

        simulator().run_on_twin(conductor, setup, folder, jobs=several, progress=progress)

    return execute


def executor_of_made_batches(folder: Path) -> Execute:
    """Use batches that a runner has made already; PlanFailed when a run is missing."""

    def execute(plan: CampaignPlan, _text: str, _left: float) -> None:
        conductor = conductor_of(folder, plan)
        if not conductor.over:
            raise PlanFailed(
                f"{plan.name}: {conductor.done} of {conductor.total} runs are made; "
                "start the investigation again to continue"
            )

    return execute


NOTEBOOK = "investigation.txt"


def open_loop(
    folder: Path,
    minutes: float,
    execute: Execute,
    tire: str = "",
    effects: tuple[str, ...] = (),
    say: Say = lambda _: None,
) -> Loop:
    """Loop of the investigation in a folder, with the events of its log."""
    bench = CampaignBench(folder, tire_of(tire, folder), execute, effects)

    def at_end(session: Session, result: Diagnosis) -> dict[str, Any] | None:
        if result.search is not None:
            page = folder / REPORT / DIAGNOSIS
            write_report(result, page, str(folder), about=session.about)
        return propose_effect(session, result, folder)

    return Loop(bench, DiskLog(folder), minutes, say, at_end=at_end)


def save_notebook(loop: Loop, folder: Path) -> Path:
    """Write the notebook as text and as a page; returns the page."""
    write_atomic(folder / NOTEBOOK, text_of(loop.log.events) + "\n")
    about = provenance(campaign_so_far(folder).records())
    return write_notebook(loop.log.events, folder / REPORT, str(folder), about)


def tire_of(name: str, folder: Path) -> TireEntry:
    """The tire `name`, else that of the runs in the folder, else the first known one."""
    known = known_tires()
    if not name and (folder / "campaign.yaml").exists():
        name = Campaign.load(folder).tire
    name = name or next(iter(known))
    if name not in known:
        raise FlatplankError(
            f"unknown tire '{name}'{nearest_hint(name, known)}", str(folder), "name it: --tire"
        )
    return known[name]


def propose_effect(session: Session, result: Diagnosis, folder: Path) -> dict[str, Any] | None:
    """Effect proposed by the grammar for a residual that the library does not explain, and its
    file."""
    if result.verdict not in (verdict.NONE, verdict.PARTLY):
        return None
    made = propose_from_diagnosis(session, result)
    if made.verdict != PROPOSED or made.sentence is None:
        return {"verdict": made.verdict, "reason": made.reason}
    path = folder / f"{made.name}{proposal_file.SUFFIX}"
    if not path.exists():  # it may have been edited by hand
        write_atomic(path, made.text)
    return {"verdict": made.verdict, "reason": made.sentence.words(), "file": str(path)}
