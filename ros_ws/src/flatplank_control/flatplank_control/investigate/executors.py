# SPDX-License-Identifier: Apache-2.0
"""Who makes a batch: the twin in this process, or the runner of a graph."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

from flatplank_control.bench.setup import BenchSetup
from flatplank_control.bench.simulator import simulator
from flatplank_control.calibration.book import book_for
from flatplank_control.investigate.bench import Execute
from flatplank_control.runner.campaign import SUFFIX, CampaignPlan, Conductor, Journal

Listen = Callable[[Any, Path], AbstractContextManager[Callable[[], None]]]
"""client and journal -> a context with what is called again and again while a batch is made"""


def on_twin(folder: Path, preset: str, plant: str, seed: int, jobs: int | None) -> Execute:
    """Every batch with the same plant."""
    setup = BenchSetup(
        preset=preset, plant_file=plant, seed=seed, pace="hold",
        calibration=str(book_for(folder).path),
    )  # fmt: skip

    def execute(plan: CampaignPlan, _text: str, left: float) -> None:
        conductor = Conductor(
            plan, Journal(folder / f"{plan.name}{SUFFIX}", plan.name, plan.digest)
        )
        several = min(jobs or os.cpu_count() or 1, max(conductor.total - conductor.done, 1))

        def progress(_conductor, _job, outcome) -> None:
            tell(f"{outcome.file}: {outcome.text()}; {left:.0f} min left after this batch")

        simulator().run_on_twin(conductor, setup, folder, jobs=several, progress=progress)

    return execute


def on_graph(folder: Path, simulated: bool, listen: Listen) -> Execute:
    """The runner of the running bench, while an operator may have wishes."""

    def execute(plan: CampaignPlan, text: str, left: float) -> None:
        from flatplank_control.nodes.client import BenchClient

        journal = folder / f"{plan.name}{SUFFIX}"

        said = [""]

        def hear(f) -> None:
            line = f.prompt or f.step
            if line != said[0] or f.prompt:  # what is asked again is said again
                said[0] = line
                tell(f"{line}; {left + f.time_left / 60.0:.0f} min left")

        with BenchClient() as client, listen(client, journal) as idle:
            client.measure(
                text, simulated=simulated, folder=str(folder), resume=True, hear=hear,
                idle=idle,
            )  # fmt: skip

    return execute


def tell(line: str) -> None:
    """Progress goes beside what a program reads."""
    print(line, file=sys.stderr, flush=True)
