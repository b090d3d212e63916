# SPDX-License-Identifier: Apache-2.0
"""Measurements without any fault: the safety rules let every one of them finish."""

from __future__ import annotations

import random
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path

from flatplank_analysis.parallel import Serial, worker_pool
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.runner.measurement import PROFILED, Measurement
from flatplank_control.runner.plans import PLANS, axes_of, plan_of
from flatplank_control.runner.steps import PlanFailed
from flatplank_data.run_record import RunRecord
from flatplank_sim.twin.twin import Cycle, Twin
from flatplank_sim.twin.twin_bench import TwinBench
from flatplank_validation.trust.registry import Options, Tally, row

NIGHT = 600
"""measurements of a night"""
TIRES = ("toyo", "continental", "michelin", "racing")
PRESETS = ("", "thesis2023")
RATES = (250, 1000)
SLIP = (-0.3, 0.3)
FZ = (1500.0, 6000.0)
PROFILE = {"amplitude": 0.1, "rate": 0.05}
"""[rad], [rad/s]"""


class NoLog:
    """Keeps nothing."""

    def start(self, record: RunRecord, stamp_ns: int, at_once: bool = False) -> None: ...

    def add(self, cycle: Cycle) -> None: ...

    def stop(self, status: str, notes: str) -> Path:
        return Path()


@dataclass(frozen=True)
class Work:
    """A measurement on a simulated bench."""

    measurement: Measurement
    tire: str
    rate_hz: int
    preset: str
    automatic: bool
    """automatic start of free rolling"""
    seed: int

    @property
    def text(self) -> str:
        """One line."""
        m, start = self.measurement, "automatic" if self.automatic else "fixed"
        return (
            f"{m.measurement}, {self.tire}, {m.fz:.0f} N, kappa {m.kappa:.3f}, {self.rate_hz} Hz, "
            f"preset '{self.preset}', {start} start, seed {self.seed}"
        )

    def bench(self) -> BenchSetup:
        """The bench that it needs."""
        start = {"free_rolling_controller": {"automatic": self.automatic}}
        return BenchSetup(
            tire=self.tire, preset=self.preset, rate_hz=self.rate_hz, seed=self.seed,
            axes=axes_of(self.measurement), pace="hold", parameters=start,
        )  # fmt: skip


def drawn(count: int, seed: int) -> list[Work]:
    """Every kind of measurement in turn; tire, load, slip, rate and preset are drawn."""
    draw, kinds = random.Random(seed), list(PLANS)
    return [
        Work(
            Measurement(
                measurement=kinds[k % len(kinds)], kappa=draw.uniform(*SLIP),
                fz=draw.uniform(*FZ), step_position=0.4, end_position=0.9, profile_time=10.0,
                profile_parameters=PROFILE if kinds[k % len(kinds)] in PROFILED else {},
            ),
            draw.choice(TIRES), draw.choice(RATES), draw.choice(PRESETS), draw.random() < 0.5, k,
        )
        for k in range(count)
    ]  # fmt: skip


def failure(work: Work) -> str:
    """Empty, or why a measurement did not finish."""
    try:
        TwinBench(Twin(work.bench()), NoLog()).perform(plan_of(work.measurement))
    except PlanFailed as error:
        return f"{work.text}: {error}"
    return ""


@row("work", "measurements of every kind without a fault", "a safety rule stops the wheel")
def faultless(o: Options) -> Tally:
    """Drawn by the seed."""
    todo, out = drawn(o.count(NIGHT), o.seed), Tally()
    pool = worker_pool(min(o.jobs, len(todo))) if o.jobs > 1 else nullcontext(Serial())
    with pool as workers:
        for text in workers.map(failure, todo):
            out.add(text)
            o.progress(out.many, len(todo))
    return out
