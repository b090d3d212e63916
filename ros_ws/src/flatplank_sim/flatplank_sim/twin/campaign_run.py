# SPDX-License-Identifier: Apache-2.0
"""A campaign plan on the twin: a fresh simulated bench per run, on as many cores as are wanted."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import replace
from pathlib import Path

from flatplank_analysis.parallel import worker_pool
from flatplank_control.bench.judging import outcome_of
from flatplank_control.bench.listing import list_kept
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.runner.campaign.conductor import Conductor, Job, Outcome
from flatplank_control.runner.campaign.plan import CampaignPlan
from flatplank_control.runner.campaign.quality import Limits
from flatplank_control.runner.campaign.supervised import supervised
from flatplank_control.runner.plans import axes_of
from flatplank_control.runner.standstill import Standstill
from flatplank_control.runner.turn_watch import TurnWatch
from flatplank_sim.twin.log import BagLog, TableLog
from flatplank_sim.twin.twin import Twin
from flatplank_sim.twin.twin_bench import TwinBench

Progress = Callable[[Conductor, Job, Outcome], None]


def setup_for(plan: CampaignPlan, setup: BenchSetup) -> BenchSetup:
    """The simulated bench with the tire of the plan on it."""
    needed = {axis for run in plan.runs for axis in axes_of(run.measurement)}
    wheel = {**setup.parameters.get("wheel_drive", {}), "free_radius": plan.tire.free_radius}
    return replace(
        setup,
        tire=plan.tire.plant,
        axes=tuple(sorted(needed.union(setup.axes))),
        parameters={**setup.parameters, "wheel_drive": wheel},
    )


def make(job: Job, setup: BenchSetup, folder: Path, bags: bool, limits: Limits) -> Outcome:
    """One run on a fresh bench whose noise has its own seed, judged."""
    index = job.measurement.run_index
    setup = replace(setup, seed=setup.seed + 1000 * index + job.attempt - 1)
    log = BagLog(folder) if bags else TableLog(folder)
    bench = TwinBench(Twin(setup), log)
    bench.twin.plant.set_run(index)
    before, after = Standstill("before the run"), Standstill("after the run")
    turn = TurnWatch()
    bench.perform(supervised(job.measurement, before, after, turn))
    return outcome_of(bench.kept[0], job, limits, before, after, turn)


def run_on_twin(
    conductor: Conductor,
    setup: BenchSetup,
    folder: Path,
    *,
    bags: bool = False,
    jobs: int = 1,
    progress: Progress = lambda _conductor, _job, _outcome: None,
) -> None:
    """All runs of the plan that are not done; the journal and campaign.yaml grow with each."""
    folder.mkdir(parents=True, exist_ok=True)
    setup = setup_for(conductor.plan, setup)
    list_kept(conductor, folder)
    arguments = (setup, folder, bags, conductor.plan.quality)

    def take_in(job: Job, outcome: Outcome) -> None:
        outcome = conductor.finish(job, outcome)
        list_kept(conductor, folder)
        progress(conductor, job, outcome)

    if jobs == 1:
        while job := conductor.take():
            take_in(job, make(job, *arguments))
        return
    with worker_pool(jobs) as pool:
        under_way: dict[Future, Job] = {}
        while not conductor.over:
            while len(under_way) < jobs and (job := conductor.take()):
                under_way[pool.submit(make, job, *arguments)] = job
            for task in wait(under_way, return_when=FIRST_COMPLETED).done:
                take_in(under_way.pop(task), task.result())
