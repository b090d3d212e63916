# SPDX-License-Identifier: Apache-2.0
"""Measure until it is decided what is missing: diagnose, choose the next run, measure, again."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout
from pathlib import Path
from typing import Any

from flatplank_analysis.cli import common, loop
from flatplank_analysis.cli.arguments import Parser
from flatplank_analysis.discovery import verdict
from flatplank_analysis.discovery.modelfile import write_atomic
from flatplank_analysis.discovery.report.page import write_report
from flatplank_analysis.discovery.verdict import Diagnosis
from flatplank_analysis.errors import FlatplankError
from flatplank_analysis.investigation.loop import Loop
from flatplank_analysis.investigation.notebook import summary, text_of
from flatplank_analysis.investigation.report import DIAGNOSIS, write_notebook
from flatplank_analysis.proposal.propose import PROPOSED, of_diagnosis
from flatplank_analysis.tirebase.session import Session
from flatplank_control.cli.keys import Keys
from flatplank_control.cli.run import KEYS, on_key
from flatplank_control.investigate.bench import REPORT, CampaignBench, Execute
from flatplank_control.investigate.executors import on_graph, on_twin, tell
from flatplank_control.investigate.journal import DiskLog
from flatplank_control.runner.campaign.tires import TireEntry, known_tires
from flatplank_control.runner.steps import PlanFailed
from flatplank_hw.params import nearest

STOPPED = 130
NOTEBOOK = "investigation.txt"


def parser() -> argparse.ArgumentParser:
    p = Parser(prog="flatplank investigate", description=__doc__)
    p.add_argument("folder", type=Path, metavar="DIR", help="campaign folder; may be new")
    p.add_argument("--minutes", type=float, default=60.0, help="of bench time; default: 60")
    p.add_argument("--tire", default="", help="of config/tires.yaml; default: as the runs say")
    p.add_argument("--effects", metavar="FILE", action="append", default=[], help="Python file")
    p.add_argument("--lab", action="store_true", help="manual steps are asked for")
    p.add_argument("--sim", action="store_true", help="on the twin, in this process")
    p.add_argument("--preset", default="", help="with --sim: defects of the machine")
    p.add_argument("--plant", default="", help="with --sim: YAML file laid over the plant")
    p.add_argument("--seed", type=int, default=1, help="with --sim: of the plant")
    p.add_argument("--jobs", type=int, help="with --sim: processes; default: all cores")
    p.add_argument("--json", action="store_true", help="print JSON for programs")
    return p


def main(argv: list[str]) -> int:
    """0: it came to an end, whatever the verdict; 1: stopped by the bench; 130: Ctrl-C."""
    o = parser().parse_args(argv)
    return common.guarded("investigate", lambda: _run(o))


def _run(o: argparse.Namespace) -> int:
    if not 0.0 < o.minutes < 1e5:
        raise FlatplankError(f"--minutes {o.minutes:g}", "investigate", "give 1 to 99999")
    loop.require_folder(o.folder)
    folder = o.folder.resolve()
    log = DiskLog(folder)
    bench = CampaignBench(folder, tire_of(o.tire, folder), _executor(o, folder), tuple(o.effects))
    if log.events:
        print(f"going on after {len(log.events)} events of {log.path}", file=sys.stderr)

    def say(text: str) -> None:
        print(text, file=sys.stderr if o.json else sys.stdout, flush=True)

    def at_end(session: Session, result: Diagnosis) -> dict[str, Any] | None:
        if result.search is not None:
            write_report(result, folder / REPORT / DIAGNOSIS, str(folder))
        return proposed(session, result, folder)

    try:
        Loop(bench, log, o.minutes, say, at_end=at_end).run()
    except (PlanFailed, ValueError) as error:
        print(f"flatplank investigate: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt as end:
        why = f" ({end})" if str(end) else ""
        print(
            f"flatplank investigate: stopped{why}; the same command goes on where it ended",
            file=sys.stderr,
        )
        return STOPPED
    write_atomic(folder / NOTEBOOK, text_of(log.events) + "\n")
    page = write_notebook(log.events, folder / REPORT, str(folder))
    if o.json:
        print(json.dumps(summary(log.events), indent=1))
    else:
        print(text_of(log.events))
        print(f"notebook: {folder / NOTEBOOK}, as a page: {page}")
    return 0


def tire_of(name: str, folder: Path) -> TireEntry:
    """As named, else as the runs of the folder say, else the first one that is known."""
    known = known_tires()
    if not name and folder.exists() and any(folder.iterdir()):
        from flatplank_analysis.data import Campaign

        name = Campaign.load(folder).tire if (folder / "campaign.yaml").exists() else ""
    name = name or next(iter(known))
    if name not in known:
        raise FlatplankError(
            f"unknown tire '{name}'{nearest(name, known)}", str(folder), "name it: --tire"
        )
    return known[name]


def _executor(o: argparse.Namespace, folder: Path) -> Execute:
    if o.sim:
        return on_twin(folder, o.preset, o.plant, o.seed, o.jobs)
    if o.preset or o.plant:
        raise FlatplankError("--preset and --plant", "investigate", "go with --sim only")
    if sys.stdin.isatty():
        tell("keys: " + ", ".join(f"{k} {what}" for k, what in KEYS.items()))
    return on_graph(folder, not o.lab, listen)


@contextmanager
def listen(client: Any, journal: Path) -> Iterator[Callable[[], None]]:
    """The keys of `flatplank run` while a batch is made; what they say goes beside the result."""
    with redirect_stdout(sys.stderr), Keys() as keys:
        yield lambda: on_key(keys, client, journal)


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
