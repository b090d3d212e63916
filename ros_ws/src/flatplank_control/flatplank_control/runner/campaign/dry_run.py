# SPDX-License-Identifier: Apache-2.0
"""A whole campaign on paper: how long it takes, how much road and load it needs."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from flatplank_control.runner.campaign.plan import CampaignPlan
from flatplank_control.runner.dry_bench import DryBench
from flatplank_control.runner.measurement import ROAD_LENGTH
from flatplank_control.runner.plans import plan_of
from flatplank_control.runner.steps import Manual, PlanFailed


@dataclass(frozen=True)
class DryRun:
    """What a campaign will take."""

    durations: dict[str, float]
    """bench time of each run by its key [s]"""
    kinds: dict[str, int]
    """runs per kind of measurement and role"""
    road: float
    """farthest position of the plank [m]"""
    largest_load: float
    """[N]"""
    prompts: int
    """things that an operator sets by hand"""

    @property
    def total(self) -> float:
        """[s]"""
        return sum(self.durations.values())

    def lines(self, plan: CampaignPlan) -> list[str]:
        """For people."""
        kinds = ", ".join(f"{n} {kind}" for kind, n in self.kinds.items())
        hours = self.total / 3600.0
        return [
            f"plan {plan.name}: {len(plan.runs)} runs ({kinds}) with the {plan.tire.name}",
            f"bench time {hours:.1f} h without repeats ({self.total / len(plan.runs):.0f} s each)",
            f"road {self.road:.2f} m of {ROAD_LENGTH:.2f} m, up to {self.largest_load:.0f} N, "
            f"{self.prompts} settings by hand",
        ]


def dry_run(plan: CampaignPlan) -> DryRun:
    """Perform every run on paper, one after the other; PlanFailed names line and reason."""
    bench = DryBench()
    durations: dict[str, float] = {}
    for run in plan.runs:
        before = bench.time
        try:
            bench.perform(plan_of(run.measurement))
        except (PlanFailed, ValueError) as error:
            raise PlanFailed(f"{plan.where}:{run.line}: {error}") from None
        durations[run.key] = bench.time - before
    kinds = Counter(
        run.measurement.measurement if run.role == "run" else f"{run.role} run"
        for run in plan.runs
    )
    by_hand = [step for step in bench.steps if isinstance(step, Manual)]
    loads = [step.value for step in by_hand if step.quantity == "load"]
    return DryRun(durations, dict(kinds), bench.road_used, max(loads, default=0.0), len(by_hand))
