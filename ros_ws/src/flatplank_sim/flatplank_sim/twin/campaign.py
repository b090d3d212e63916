# SPDX-License-Identifier: Apache-2.0
"""Makes many measurements on the twin in parallel: one new simulated bench per run."""

from __future__ import annotations

import gc
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import replace
from functools import lru_cache, partial
from pathlib import Path

from flatplank_analysis.parallel import open_executor, worker_pool
from flatplank_control.bench.results import (
    outcome_of,
    outcome_of_stopped,
    write_campaign,
    write_kept_runs,
)
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.runner.campaign.conductor import Conductor, Job, Outcome
from flatplank_control.runner.campaign.plan import CampaignPlan
from flatplank_control.runner.campaign.quality import Limits
from flatplank_control.runner.campaign.supervised import Standstill, TurnWatch, supervised
from flatplank_control.runner.measurement import START_ANGLES, Measurement
from flatplank_control.runner.plans import axes_of, plan_of
from flatplank_control.runner.steps import PlanFailed
from flatplank_sim.twin.log import BagLog, TableLog
from flatplank_sim.twin.twin import Twin
from flatplank_sim.twin.twin_bench import TwinBench

SLIPS = (0.0, 0.01, -0.01, 0.02, -0.02, 0.05, -0.05, 0.1, -0.1)
"""slip levels of thesis section 6.2 [-]"""
Progress = Callable[[int, int, str], None]


def slips_by_starts(
    base: Measurement, slips: Sequence[float], starts: Sequence[int]
) -> list[Measurement]:
    """Measurements with every slip from every start, in order."""
    pairs = [(kappa, start) for kappa in slips for start in starts]
    return [
        replace(base, kappa=kappa, start=start, run_index=k)
        for k, (kappa, start) in enumerate(pairs)
    ]


def starts_of(text: str) -> list[int]:
    """Parse starts such as `1,2,3`; ValueError names the allowed ones."""
    starts = [int(word) if word.strip().isdigit() else -1 for word in text.split(",")]
    for start in starts:
        if start not in START_ANGLES:
            raise ValueError(f"starts '{text}': give 1, 2, 3 (0, 120, 240 deg), with commas")
    return starts


def fresh_bench(
    setup: BenchSetup, run_index: int, attempt: int, folder: Path, bags: bool
) -> TwinBench:
    """A new bench for one run, with its own noise seed."""
    log = BagLog(folder) if bags else TableLog(folder)
    setup = replace(setup, seed=setup.seed + 1000 * run_index + attempt - 1)
    bench = TwinBench(Twin(setup), log)
    bench.twin.plant.set_run(run_index)
    return bench


@lru_cache(maxsize=1)
def keep_modules() -> None:
    """Exempt what is imported from garbage collection, which the samples of runs start often."""
    gc.collect()
    gc.freeze()


def simulate_one(m: Measurement, setup: BenchSetup, folder: Path, bags: bool) -> Path:
    """Make one measurement on a new bench."""
    keep_modules()
    bench = fresh_bench(setup, m.run_index, 1, folder, bags)
    bench.perform(plan_of(m))
    return bench.kept[0]


def simulate_many(
    measurements: Sequence[Measurement],
    setup: BenchSetup,
    folder: Path,
    *,
    bags: bool = False,
    jobs: int | None = None,
    progress: Progress = lambda _done, _all, _name: None,
) -> list[Path]:
    """Make all measurements; adds files and `campaign.yaml` entries to those in `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    make = partial(simulate_one, setup=setup, folder=folder, bags=bags)
    paths: list[Path] = []
    with open_executor(jobs) as executor:
        for path in executor.map(make, measurements):
            paths.append(path)
            progress(len(paths), len(measurements), path.name)
    made = [(m.record(), path.name) for m, path in zip(measurements, paths, strict=True)]
    write_campaign(folder, measurements[0].tire, made)
    return paths


def setup_for(plan: CampaignPlan, setup: BenchSetup) -> BenchSetup:
    """Setup with the tire and the driven axes that the plan needs."""
    needed = {axis for run in plan.runs for axis in axes_of(run.measurement)}
    wheel = {**setup.parameters.get("wheel_drive", {}), "free_radius": plan.tire.free_radius}
    return replace(
        setup,
        tire=plan.tire.plant,
        axes=tuple(sorted(needed.union(setup.axes))),
        parameters={**setup.parameters, "wheel_drive": wheel},
    )


def make_run(job: Job, setup: BenchSetup, folder: Path, bags: bool, limits: Limits) -> Outcome:
    """Make one run on a new bench and check its quality; a stop on the way ends this run only."""
    keep_modules()
    bench = fresh_bench(setup, job.measurement.run_index, job.attempt, folder, bags)
    before, after = Standstill("before the run"), Standstill("after the run")
    turn = TurnWatch()
    try:
        bench.perform(supervised(job.measurement, before, after, turn))
    except PlanFailed as stop:
        return outcome_of_stopped(next(iter(bench.kept), None), job, str(stop))
    return outcome_of(bench.kept[0], job, limits, before, after, turn)


def run_on_twin(
    conductor: Conductor,
    setup: BenchSetup,
    folder: Path,
    *,
    bags: bool = False,
    jobs: int = 1,
    progress: Callable[[Conductor, Job, Outcome], None] = lambda _conductor, _job, _outcome: None,
) -> None:
    """Make all remaining runs of the plan; updates the journal and campaign.yaml after each."""
    folder.mkdir(parents=True, exist_ok=True)
    setup = setup_for(conductor.plan, setup)
    write_kept_runs(conductor, folder)
    arguments = (setup, folder, bags, conductor.plan.quality)

    def take_in(job: Job, outcome: Outcome) -> None:
        outcome = conductor.finish(job, outcome)
        write_kept_runs(conductor, folder)
        progress(conductor, job, outcome)

    if jobs == 1:
        while job := conductor.next_job():
            take_in(job, make_run(job, *arguments))
        return
    with worker_pool(jobs) as pool:
        under_way: dict[Future, Job] = {}
        while not conductor.over:
            while len(under_way) < jobs and (job := conductor.next_job()):
                under_way[pool.submit(make_run, job, *arguments)] = job
            for task in wait(under_way, return_when=FIRST_COMPLETED).done:
                take_in(under_way.pop(task), task.result())
