# SPDX-License-Identifier: Apache-2.0
"""Linear, nonlinear and Magic Formula fits of 800 runs from Parquet tables on two processes.

The tables (44,000 samples each) are written to a temporary folder first; writing is not timed.

    python -m flatplank_validation.fits.campaign_fit
"""

from __future__ import annotations

import resource
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import yaml

from flatplank_analysis.identify.campaign import FitFile, fit_campaign
from flatplank_analysis.identify.runs import StepRun, step_run
from flatplank_data.campaign import Campaign, Run
from flatplank_tire.tir import shipped_tir
from flatplank_validation.fits.campaigns import SLIPS, Truth, simulate_runs
from flatplank_validation.fits.command import command

RADIUS = 0.311
STEP = 1.5
COLUMNS = ("plank_position", "wheel_angle", "fx", "fy", "mz", "fz")


def conditions(runs: int) -> list[Truth]:
    """Conditions over load and pressure, each of nine slips x three starts."""
    count = -(-runs // (3 * len(SLIPS)))
    loads = np.linspace(1500.0, 7000.0, 6)
    pressures = np.linspace(2.0e5, 3.0e5, -(-count // 6))
    made = [
        Truth(fz=float(fz), pressure=float(p), slip_stiffness=25.0 * float(fz))
        for p in pressures
        for fz in loads
    ]
    return made[:count]


def write_campaign(folder: Path, runs: int, samples: int = 44_000) -> int:
    """Write tables and campaign.yaml; returns the number of runs."""
    rng = np.random.default_rng(4)
    records: list[dict[str, Any]] = []
    for truth in conditions(runs):
        for run in simulate_runs(truth, rng):
            if len(records) == runs:
                break
            records.append(_write_run(folder, run, len(records), samples, rng))
    head = {"format": "flatplank-measurement-table/1", "tire": "TOY", "runs": records}
    (folder / "campaign.yaml").write_text(yaml.safe_dump(head))
    return len(records)


def _write_run(
    folder: Path, run: StepRun, number: int, samples: int, rng: np.random.Generator
) -> dict:
    x = np.linspace(0.0, STEP + run.distance[-1], samples)
    after = np.maximum(x - STEP, 0.0)
    noise = 3.0 * rng.standard_normal(samples)
    zero = np.zeros(samples)
    columns = {
        "time": x / 0.031,
        "plank_position": x,
        "plank_velocity": np.full(samples, 0.031),
        "wheel_angle": (x + run.level * after) / RADIUS,
        "wheel_velocity": np.full(samples, 0.1),
        "fx": np.interp(x - STEP, run.distance, run.fx) + noise,
        "fy": zero,
        "fz": np.full(samples, run.mean_load),
        "mx": zero,
        "my": zero,
        "mz": zero,
    }
    name = f"run_{number:04d}.parquet"
    pq.write_table(pa.table({k: v.astype(np.float32) for k, v in columns.items()}), folder / name)
    return {
        "file": name,
        "tire": "TOY",
        "kappa": run.level,
        "fz": round(run.mean_load, 1),
        "pressure": run.pressure / 1e5,
        "alpha_deg": 0.0,
        "gamma_deg": 0.0,
        "start": run.start,
        "run_index": number,
        "effective_rolling_radius": RADIUS,
        "step_position": STEP,
    }


def _load(run: Run) -> StepRun:
    return step_run(run.table(COLUMNS))


def measure(runs: int = 800, workers: int = 2) -> dict[str, float]:
    """Times [s] of reading and of each fit, and the largest memory of a process [MiB]."""
    numbers: dict[str, float] = {"workers": workers}
    with tempfile.TemporaryDirectory() as name, ProcessPoolExecutor(workers) as pool:
        numbers["runs"] = write_campaign(Path(name), runs)
        begin = last = time.perf_counter()
        loaded = list(pool.map(_load, Campaign.load(name).runs, chunksize=8))
        numbers["read_s"] = time.perf_counter() - last
        for model in ("linear", "nonlinear", "mf"):
            last = time.perf_counter()
            fit_campaign(loaded, FitFile(model), start=shipped_tir(), mapper=pool.map)
            numbers[f"{model}_s"] = time.perf_counter() - last
        numbers["total_s"] = time.perf_counter() - begin
    for who, label in ((resource.RUSAGE_SELF, "self"), (resource.RUSAGE_CHILDREN, "worker")):
        numbers[f"memory_{label}_MiB"] = resource.getrusage(who).ru_maxrss / 1024.0
    return numbers


main = command(__doc__, lambda chosen: measure(chosen.runs, chosen.workers), runs=800, workers=2)

if __name__ == "__main__":
    main()
