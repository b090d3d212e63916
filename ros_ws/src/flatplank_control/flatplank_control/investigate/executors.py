# SPDX-License-Identifier: Apache-2.0
"""Who makes a batch: the twin in this process, or somebody else."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from flatplank_control.bench.setup import BenchSetup
from flatplank_control.bench.simulator import simulator
from flatplank_control.calibration.book import book_for
from flatplank_control.investigate.bench import Execute
from flatplank_control.runner.campaign import SUFFIX, CampaignPlan, Conductor, Journal
from flatplank_control.runner.steps import PlanFailed


def conductor_of(folder: Path, plan: CampaignPlan) -> Conductor:
    """What there is of a batch."""
    return Conductor(plan, Journal(folder / f"{plan.name}{SUFFIX}", plan.name, plan.digest))


def on_twin(
    folder: Path,
    preset: str,
    plant: str,
    seed: int,
    jobs: int | None,
    say: Callable[[str], None],
) -> Execute:
    """Every batch with the same plant."""
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


def made_elsewhere(folder: Path) -> Execute:
    """The batch was made by a runner already; PlanFailed when a part of it is lacking."""

    def execute(plan: CampaignPlan, _text: str, _left: float) -> None:
        conductor = conductor_of(folder, plan)
        if not conductor.over:
            raise PlanFailed(
                f"{plan.name}: {conductor.done} of {conductor.total} runs are made; begin again "
                "goes on there"
            )

    return execute
