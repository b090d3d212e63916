# SPDX-License-Identifier: Apache-2.0
"""Many measurements on the twin: one fresh simulated bench per run, over all cores."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import as_completed
from dataclasses import replace
from pathlib import Path

from flatplank_analysis.parallel import worker_pool
from flatplank_control.bench.listing import write_campaign
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.runner.measurement import START_ANGLES, Measurement
from flatplank_control.runner.plans import plan_of
from flatplank_sim.twin.log import BagLog, TableLog
from flatplank_sim.twin.twin import Twin
from flatplank_sim.twin.twin_bench import TwinBench

SLIPS = (0.0, 0.01, -0.01, 0.02, -0.02, 0.05, -0.05, 0.1, -0.1)
"""section 6.2"""
Progress = Callable[[int, int, str], None]


def matrix(base: Measurement, slips: Sequence[float], starts: Sequence[int]) -> list[Measurement]:
    """Every slip from every start, in the order in which they are made."""
    pairs = [(kappa, start) for kappa in slips for start in starts]
    return [
        replace(base, kappa=kappa, start=start, run_index=k)
        for k, (kappa, start) in enumerate(pairs)
    ]


def starts_of(text: str) -> list[int]:
    """`1,2,3` to starts; ValueError says what is allowed."""
    starts = [int(word) if word.strip().isdigit() else -1 for word in text.split(",")]
    for start in starts:
        if start not in START_ANGLES:
            raise ValueError(f"starts '{text}': give 1, 2, 3 (0, 120, 240 deg), with commas")
    return starts


def simulate_one(m: Measurement, setup: BenchSetup, folder: Path, bags: bool) -> Path:
    """One measurement on a fresh bench whose noise has its own seed."""
    setup = replace(setup, seed=setup.seed + 1000 * m.run_index)
    log = BagLog(folder) if bags else TableLog(folder)
    bench = TwinBench(Twin(setup), log)
    bench.twin.plant.set_run(m.run_index)
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
    """All measurements; files and `campaign.yaml` in `folder`, joined to those that are there."""
    folder.mkdir(parents=True, exist_ok=True)
    jobs = min(jobs or os.cpu_count() or 1, len(measurements)) or 1
    done: dict[int, Path] = {}
    for k, path in _run(measurements, setup, folder, bags, jobs):
        done[k] = path
        progress(len(done), len(measurements), path.name)
    paths = [done[k] for k in range(len(measurements))]
    made = [(m.record(), path.name) for m, path in zip(measurements, paths, strict=True)]
    write_campaign(folder, measurements[0].tire, made)
    return paths


def _run(
    measurements: Sequence[Measurement], setup: BenchSetup, folder: Path, bags: bool, jobs: int
) -> Iterator[tuple[int, Path]]:
    if jobs == 1:
        for k, m in enumerate(measurements):
            yield k, simulate_one(m, setup, folder, bags)
        return
    with worker_pool(jobs) as pool:
        tasks = {
            pool.submit(simulate_one, m, setup, folder, bags): k
            for k, m in enumerate(measurements)
        }
        for task in as_completed(tasks):
            yield tasks[task], task.result()
