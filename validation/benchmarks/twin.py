# SPDX-License-Identifier: Apache-2.0
"""Measures the speed of the twin: bench time per second on one core, with tables and with bags."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

from flatplank_control.bench.setup import BenchSetup
from flatplank_control.runner.measurement import Measurement
from flatplank_control.runner.plans import plan_of
from flatplank_sim.twin.log import BagLog, TableLog
from flatplank_sim.twin.twin import Twin
from flatplank_sim.twin.twin_bench import TwinBench

WANTED = {"tables": 60, "bags": 20}


def rate(kind: str, m: Measurement) -> float:
    """Bench time over processor time of one measurement."""
    with tempfile.TemporaryDirectory() as folder:
        log = {"tables": TableLog, "bags": BagLog}[kind](Path(folder))
        bench = TwinBench(Twin(BenchSetup(pace="hold")), log)
        begin = time.process_time()
        bench.perform(plan_of(m))
        return bench.snapshot().encoders.stamp_ns * 1e-9 / (time.process_time() - begin)


def main() -> None:
    rate("tables", Measurement(step_position=0.01, end_position=0.02))  # compiles the kernels
    print("twin at 250 Hz, one whole slip measurement, per core (processor time):")
    for kind, wanted in WANTED.items():
        best = max(rate(kind, Measurement(kappa=0.05)) for _ in range(2))
        print(f"  with {kind:7} {best:6.0f} x real time (wanted: {wanted})")


if __name__ == "__main__":
    main()
