# SPDX-License-Identifier: Apache-2.0
"""Measure a campaign plan, on a bench or simulated (--sim)."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from typing import Any

from flatplank_control.bench.setup import BenchSetup, parse_axes
from flatplank_control.calibration.book import book_for
from flatplank_control.cli.operator import (
    OF_A_CAMPAIGN,
    Keys,
    ProgressPrinter,
    call_service_of_key,
    print_result_of_plan,
    result_of_plan,
)
from flatplank_control.runner.campaign import (
    CampaignPlan,
    Conductor,
    Job,
    Journal,
    Outcome,
    PlanError,
    load_plan,
    pressure_after,
    shipped_plans,
    write_note,
)
from flatplank_control.runner.dry_run import DryRun, dry_run
from flatplank_data.arguments import Parser, add_json, add_namespace, for_programs
from flatplank_data.journals import SUFFIX

STOPPED = 130
KEYS = {
    **{key: wish.text for key, wish in OF_A_CAMPAIGN.items()},
    "n": "note",
    "p": "pressure of the tire after the latest run",
}
"""key -> its effect"""


def parser() -> argparse.ArgumentParser:
    p = Parser(prog="flatplank run", description=__doc__)
    p.add_argument("plan", help="a file, or the name of a shipped plan")
    p.add_argument("--sim", action="store_true", help="on the twin, in this process")
    p.add_argument("--dry-run", action="store_true", help="check only, and print what it takes")
    p.add_argument("--data", type=Path, help="campaign folder; default: data/NAME")
    p.add_argument("--lab", action="store_true", help="manual steps are asked for")
    add_namespace(p)
    p.add_argument("--new", action="store_true", help="refuse to go on with an earlier campaign")
    p.add_argument("--redo", action="store_true", help="make flagged and skipped runs once more")
    p.add_argument("--jobs", type=int, help="processes of the twin; default: all cores")
    p.add_argument("--bags", action="store_true", help="the twin writes bags, not tables")
    p.add_argument("--preset", default="", help="defects of the simulated machine: thesis2023")
    p.add_argument("--plant", default="", help="YAML file laid over the simulated plant")
    p.add_argument("--road", default="", help="slip by the road's travel: follow, or a map's file")
    p.add_argument("--axes", default="", help="with --sim: driven also, plank for instance")
    p.add_argument("--seed", type=int, default=1, help="of the simulated plant")
    add_json(p)
    return p


def find_plan(name: str) -> Path:
    """Find a plan: a file, or a packaged plan by name."""
    path = Path(name)
    if path.exists() or path.suffix:
        return path
    shipped = shipped_plans()
    if name not in shipped:
        known = ", ".join(shipped)
        raise PlanError([f"{name}: neither a file nor a shipped plan; shipped are {known}"])
    return shipped[name]


def schedule_bad_runs_again(plan: CampaignPlan, folder: Path) -> None:
    """Schedule flagged and skipped runs again; ValueError when there is no journal."""
    path = folder / f"{plan.name}{SUFFIX}"
    if not path.is_file():
        raise ValueError(f"--redo: {folder} has no runs of this plan yet; leave it out")
    journal = Journal(path, plan.name, plan.digest)
    needs_repeat = [run.key for run in plan.runs if journal.needs_repeat(run.key)]
    for key in needs_repeat:
        journal.schedule_again(key)
    print(f"{len(needs_repeat)} flagged or skipped runs are made once more", flush=True)


def measure_on_twin(plan: CampaignPlan, paper: DryRun, o: argparse.Namespace, folder: Path) -> int:
    """Run the campaign on the twin, in this process."""
    from flatplank_control.bench.simulator import simulator
    from flatplank_control.road_map import with_road

    journal = Journal(folder / f"{plan.name}{SUFFIX}", plan.name, plan.digest)
    setup = BenchSetup(
        preset=o.preset, plant_file=o.plant, seed=o.seed, pace="hold",
        axes=parse_axes(o.axes, "--axes"), calibration=str(book_for(folder).path),
    )  # fmt: skip
    conductor = Conductor(plan, journal)
    if conductor.done and o.new:
        print(f"flatplank run: {folder} has {conductor.done} runs of this plan", file=sys.stderr)
        return 1
    if conductor.done:
        print(f"going on after {conductor.done} of {conductor.total} runs")
    jobs = min(o.jobs or os.cpu_count() or 1, max(conductor.total - conductor.done, 1))
    setup = with_road(setup, o.road)
    talk = ProgressPrinter(conductor.time_left(paper.durations))

    def progress(_conductor: Conductor, _job: Job, outcome: Outcome) -> None:
        line = f"{outcome.file}: {outcome.text()}"
        talk(conductor.done, conductor.total, line, conductor.time_left(paper.durations))

    simulator().run_on_twin(conductor, setup, folder, bags=o.bags, jobs=jobs, progress=progress)
    return print_result_of_plan(plan, journal)


def measure_on_bench(plan: CampaignPlan, o: argparse.Namespace, folder: Path) -> int:
    """Run the campaign on a running bench, by its runner node."""
    from flatplank_control.nodes.client import BenchClient, BenchError

    text = Path(plan.where).read_text(encoding="utf-8")
    path = folder / f"{plan.name}{SUFFIX}"
    talk = ProgressPrinter()

    def hear(f) -> None:
        done = round(f.progress * f.measurements)
        talk(done, f.measurements, f.prompt or f.step, f.time_left, asks=bool(f.prompt))

    try:
        with BenchClient(namespace=o.namespace) as client, Keys() as keys:
            print("keys: " + ", ".join(f"{k} {what}" for k, what in KEYS.items()), flush=True)
            client.measure(
                text, simulated=not o.lab, folder=str(folder), resume=not o.new,
                hear=hear, idle=lambda: act_on_key(keys, client, path),
            )  # fmt: skip
    except BenchError as error:
        print(f"flatplank run: {error}", file=sys.stderr)
        return 1
    return print_result_of_plan(plan, Journal(path, plan.name, plan.digest))


def act_on_key(keys: Keys, client: Any, journal: Path) -> None:
    """Perform the request of a pressed key."""
    key = keys.pressed()
    if key == "n":
        write_note(journal, keys.line("note: "))
    elif key == "p":
        _pressure(journal, keys.line("pressure [bar]: "))
    else:
        call_service_of_key(client, OF_A_CAMPAIGN, key)


def _pressure(journal: Path, text: str) -> None:
    try:
        print(f"pressure after {pressure_after(journal, text)}", flush=True)
    except ValueError as error:
        print(error, flush=True)


def main(argv: list[str]) -> int:
    """Exit code 0: all runs exist and are good; 1: stopped by the bench; 2: plan refused; 3: runs
    flagged or skipped; 130: Ctrl-C."""
    o = parser().parse_args(argv)
    try:
        plan = load_plan(find_plan(o.plan))
        paper = dry_run(plan)
    except ValueError as error:
        print(f"flatplank run: refused\n{error}", file=sys.stderr)
        return 2
    with for_programs(o.json) as found:
        print("\n".join(paper.lines(plan)), flush=True)
        if o.dry_run:
            found |= {"runs": [*paper.durations], "bench_time_s": paper.total}
            return 0
        return measure(plan, paper, o, found)


def measure(
    plan: CampaignPlan, paper: DryRun, o: argparse.Namespace, found: dict[str, Any]
) -> int:
    """Measure what is left of a plan, and tell programs what became of its runs."""
    folder = (o.data or Path("data") / plan.name).resolve()
    try:
        if o.redo:
            schedule_bad_runs_again(plan, folder)
        code = (
            measure_on_twin(plan, paper, o, folder) if o.sim else measure_on_bench(plan, o, folder)
        )
    except ValueError as error:
        print(f"flatplank run: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt as end:
        why = f" ({end})" if str(end) else ""
        print(f"flatplank run: stopped{why}; the same command continues it",
              file=sys.stderr)  # fmt: skip
        return STOPPED
    found |= result_of_plan(plan, Journal(folder / f"{plan.name}{SUFFIX}", plan.name, plan.digest))
    return code
