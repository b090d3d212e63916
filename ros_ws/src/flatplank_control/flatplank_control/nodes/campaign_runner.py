# SPDX-License-Identifier: Apache-2.0
"""Runs a campaign on the graph: the conductor selects a run, the bench makes it, its bag is
judged."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from flatplank_control.bench.results import outcome_of, write_kept_runs
from flatplank_control.nodes.ros_bench import RosBench
from flatplank_control.runner.campaign import (
    Conductor,
    Job,
    Journal,
    Outcome,
    plan_from_text,
)
from flatplank_control.runner.campaign.conductor import unwritten
from flatplank_control.runner.campaign.supervised import Standstill, TurnWatch, supervised
from flatplank_control.runner.dry_run import dry_run
from flatplank_control.runner.plans import axes_of
from flatplank_control.runner.steps import Manual
from flatplank_data.journals import SUFFIX

WISHES = ("skip", "repeat", "discard")
"""requests of the operator about the present run, beside `enough`"""


class OperatorEnded(Exception):
    """The operator has ended the present run."""


class CampaignRunner:
    """One campaign; `wish` holds a request of the operator, checked between steps and during
    waits."""

    def __init__(self, bench: RosBench, text: str, folder: str, resume: bool) -> None:
        if not folder:
            raise ValueError("a campaign needs a folder for its bags and its journal")
        plan = plan_from_text(text, "plan")
        paper = dry_run(plan)
        self.bench, self.folder = bench, Path(folder)
        axes = {axis for run in plan.runs for axis in axes_of(run.measurement)}
        bench.axes = tuple(sorted(axes))
        self.wish = ""
        self.journal = Journal(self.folder / f"{plan.name}{SUFFIX}", plan.name, plan.digest)
        self.conductor = Conductor(plan, self.journal)
        self._durations = paper.durations
        if self.conductor.done and not resume:
            raise ValueError(
                f"{self.folder} has {self.conductor.done} runs of this plan; "
                "set resume to continue them, or give another folder"
            )

    async def run(self, look: Callable[[], None], send_progress: Callable[[str], None]) -> None:
        """Run the plan to its end; PlanFailed when the bench stops it, and what `look` raises,
        which is called during waits."""
        self._look, self._send_progress = look, send_progress
        self.bench.interrupt = look
        await self._clean_up()
        write_kept_runs(self.conductor, self.folder)
        self.bench.interrupt = self._check_operator
        while job := self.conductor.next_job():
            name = job.measurement.name
            send_progress(f"{name}: attempt {job.attempt}" if job.attempt > 1 else name)
            try:
                outcome = await self._make(job)
            except OperatorEnded as wish:
                await self._apply_wish(str(wish), job)
                continue
            outcome = self.conductor.finish(job, outcome)
            write_kept_runs(self.conductor, self.folder)
            send_progress(f"{outcome.file}: {outcome.text()}")

    def time_left(self) -> float:
        """Bench time of the remaining runs [s]."""
        return self.conductor.time_left(self._durations)

    async def _clean_up(self) -> None:
        """After an interrupted runner: stop the wheel, close its bag, adopt a complete one."""
        if not self.journal.interrupted:
            return
        self._send_progress("an earlier campaign was interrupted: stop the wheel, close its bag")
        await self._end("interrupted", "the runner ended")
        adopted = self._adopt()
        if adopted is not None:
            self._send_progress(
                f"{self.journal.path.name}: a complete run missing in the journal was adopted"
            )
            self._send_progress(f"{adopted.file}: {adopted.text()}")
            if self.conductor.over:  # no further run follows that would unload the tire
                await self.bench.perform(Manual("unload", 0.0))

    async def _end(self, status: str, why: str) -> None:
        for refusal in await self.bench.end_safely(status, why):
            self._send_progress(refusal)

    def _adopt(self) -> Outcome | None:
        """Adopt a complete bag that an interrupted runner has not entered into the journal."""
        job = self.conductor.next_job(self.journal.interrupted)
        if job is None:
            return None
        path = unwritten(self.folder, job, self.journal)
        if path is not None:
            nothing = Standstill("before the run"), Standstill("after the run")
            limits = self.conductor.plan.quality
            return self.conductor.finish(job, outcome_of(path, job, limits, *nothing))
        self.conductor.return_job(job)
        return None

    def _check_operator(self) -> None:
        self._look()
        if self.wish:
            wish, self.wish = self.wish, ""
            raise OperatorEnded(wish)

    async def _make(self, job: Job) -> Outcome:
        before, after = Standstill("before the run"), Standstill("after the run")
        turn = TurnWatch()
        for step in supervised(job.measurement, before, after, turn):
            self.bench.interrupt()
            await self.bench.perform(step)
        path = Path(self.bench.bags[-1])
        return outcome_of(path, job, self.conductor.plan.quality, before, after, turn)

    async def _apply_wish(self, wish: str, job: Job) -> None:
        await self._end("discarded", f"{wish} by the operator")
        if wish == "repeat":
            self.conductor.return_job(job)
        else:
            self.conductor.skip(job.run.key, f"{wish} by the operator")
        self._send_progress(f"{job.measurement.name}: {wish}")
