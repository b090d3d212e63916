# SPDX-License-Identifier: Apache-2.0
"""How far a single measurement is, by the same plan performed on paper."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress

from flatplank_control.runner.dry_bench import DryBench
from flatplank_control.runner.steps import PlanFailed, Step


class Progress:
    """`step` steps of the plan are done and the next one takes `seconds` so far."""

    def __init__(self, ends: Sequence[float]) -> None:
        """`ends`: bench time at the end of each step on paper [s]."""
        self._ends = list(ends)
        self.total = self._ends[-1] if self._ends else 0.0

    def left(self, step: int, seconds: float = 0.0) -> float:
        """Bench time to come [s]; a step that takes longer than on paper counts as done."""
        begin = self._ends[step - 1] if step else 0.0
        end = self._ends[min(step, len(self._ends) - 1)] if self._ends else 0.0
        return self.total - min(begin + seconds, end)

    def done(self, step: int, seconds: float = 0.0) -> float:
        """Share that is done, 0 .. 1."""
        return 1.0 - self.left(step, seconds) / self.total if self.total else 1.0


def on_paper(plan: Iterable[Step]) -> Progress:
    """Perform a plan on paper; what waits for something that paper does not have takes no time."""
    bench, ends = DryBench(), []
    for step in plan:
        with suppress(PlanFailed):
            bench.perform([step])
        ends.append(bench.time)
    return Progress(ends)
