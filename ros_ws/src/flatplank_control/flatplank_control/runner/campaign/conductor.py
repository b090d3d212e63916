# SPDX-License-Identifier: Apache-2.0
"""Decides which run is next: r_e first, repeats of bad runs, the remaining runs after a stop."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

from flatplank_control.runner.campaign.journal import Journal, RunEnd
from flatplank_control.runner.campaign.order import PlannedRun
from flatplank_control.runner.campaign.plan import CampaignPlan
from flatplank_control.runner.campaign.quality import Verdict, once_per_turn
from flatplank_control.runner.measurement import Measurement
from flatplank_data.run_record import FILE_NAME, load_record, record_from_dict

R_E_HOLDS = 5e-4
"""largest relative change of r_e before slip runs with the old value are repeated; equals the
accuracy required of slip [-]"""

FILTER_ON = "filter_on"
"""fact of a run: whether the parasitic filter was on"""
UNFILTERED = (
    "no parasitic filter is on: first make its fit, ./flatplank calibrate parasitic --mounting "
    "NAME with --bag TURN, or with --sim and the --preset"
)


class Job(NamedTuple):
    """A run to be made."""

    run: PlannedRun
    measurement: Measurement
    """measurement with its effective rolling radius"""
    attempt: int
    """number of the attempt, from 1"""
    earlier: tuple[list[float], ...]
    """Fx profiles of good runs of the same condition"""


@dataclass(frozen=True)
class Outcome:
    """Result of a job."""

    file: str
    verdict: Verdict
    facts: Mapping[str, Any] = field(default_factory=dict)
    """radius, Fx profile, zeros, warnings, stiffness or friction of a standing tire"""

    def text(self) -> str:
        """One line with the verdict and warnings for the operator."""
        return "; ".join([self.verdict.text(), *self.facts.get("warnings", ())])

    def warned(self, text: str) -> Outcome:
        """The same with one warning more."""
        warnings = (*self.facts.get("warnings", ()), text)
        return replace(self, facts={**self.facts, "warnings": warnings})

    @property
    def unfiltered(self) -> bool:
        """Whether a force that turns with the wheel flagged a run without the parasitic filter."""
        bad = {f.name for f in self.verdict.findings if not f.ok}
        return once_per_turn.__name__ in bad and not self.facts.get(FILTER_ON, True)


class Conductor:
    """Selects the next run and enters its outcome; independent of bench and clock."""

    def __init__(self, plan: CampaignPlan, journal: Journal) -> None:
        self.plan, self.journal = plan, journal
        self._busy: set[str] = set()
        self._index = {r.key: k for k, r in enumerate(plan.runs)}
        self._names = {r.key: record_from_dict(r.measurement.record()).name for r in plan.runs}

    @property
    def total(self) -> int:
        return len(self.plan.runs)

    @property
    def _waiting(self) -> list[PlannedRun]:
        return [
            run for run in self.plan.runs
            if not self.journal.finished(run.key) or self._outdated(run)
        ]  # fmt: skip

    @property
    def done(self) -> int:
        return self.total - len(self._waiting)

    @property
    def over(self) -> bool:
        return not self._waiting

    def next_job(self, key: str = "") -> Job | None:
        """Job of the next run whose r_e is known, or of the run `key`; None when all remaining
        runs wait for a run in progress."""
        for run in self._waiting:
            if key not in ("", run.key):
                continue
            if run.key not in self._busy and self._ready(run):
                self._busy.add(run.key)
                attempt = self._attempts(run) + 1
                self.journal.begin(run.key, attempt)
                return Job(run, self._measurement(run, attempt), attempt, self._earlier(run))
        return None

    def finish(self, job: Job, outcome: Outcome) -> Outcome:
        """Enter the outcome into the journal; returns it with a warning when other runs must be
        repeated or cannot be made, and once when the parasitic filter is missing."""
        told = any(UNFILTERED in d.facts.get("warnings", ()) for d in self.journal.done.values())
        if outcome.unfiltered and not told:
            outcome = outcome.warned(UNFILTERED)
        final = outcome.verdict.ok or job.attempt >= self.plan.attempts
        facts = {**outcome.verdict.plain(), "verdict": outcome.text(), **outcome.facts}
        record = job.measurement.record()
        self.journal.end(job.run.key, outcome.file, outcome.verdict.ok, final, facts, record)
        self._busy.discard(job.run.key)
        if final and self._radius(job.run.key) is None:
            outcome = self._without_radius(job.run, outcome)
        others = sum(run.needs == job.run.key for run in self.outdated())
        if not others:
            return outcome
        return outcome.warned(
            f"r_e is another than before: {others} runs that rest on the old one are made again"
        )

    def _without_radius(self, run: PlannedRun, outcome: Outcome) -> Outcome:
        """Skip the runs that rest on the r_e of a run which has none; the outcome says so."""
        others = sum(other.needs == run.key for other in self._waiting)
        if not others:
            return outcome
        self.skip(run.key, f"no r_e by {outcome.file}")
        return outcome.warned(f"{others} runs that rest on its r_e are skipped")

    def kept(self) -> list[RunEnd]:
        """Existing results of all runs that are not skipped, in the order of the plan."""
        known = (self.journal.done.get(run.key) for run in self.plan.runs)
        return [done for done in known if done and done.valid_file and not done.skipped]

    def outdated(self) -> list[PlannedRun]:
        """Runs made with an r_e that has since been measured anew and changed."""
        return [run for run in self.plan.runs if self._outdated(run)]

    def return_job(self, job: Job) -> None:
        """Return the job of an interrupted run, which will be made again."""
        self._busy.discard(job.run.key)

    def skip(self, key: str, why: str) -> None:
        """Skip a run and those that depend on it."""
        for run in self._waiting:
            if key in (run.key, run.needs):
                self.journal.skip(run.key, why)
                self._busy.discard(run.key)

    def time_left(self, durations: Mapping[str, float]) -> float:
        """Bench time of the remaining runs [s], from the duration of each run by its key."""
        return math.fsum(durations[run.key] for run in self._waiting)

    def _ready(self, run: PlannedRun) -> bool:
        return not run.needs or self._radius(run.needs) is not None

    def _radius(self, key: str) -> float | None:
        """r_e by a finished run [m]."""
        done = self.journal.done.get(key)
        return done.facts.get("radius") if done and done.final else None

    def _outdated(self, run: PlannedRun) -> bool:
        done = self.journal.done.get(run.key)
        if not run.needs or done is None or done.skipped:
            return False
        now, then = self._radius(run.needs), done.record.get("effective_rolling_radius")
        return bool(now and then and abs(now / then - 1.0) > R_E_HOLDS)

    def _attempts(self, run: PlannedRun) -> int:
        done = self.journal.done.get(run.key)
        return done.attempts if done else 0

    def _measurement(self, run: PlannedRun, attempt: int) -> Measurement:
        m = replace(
            run.measurement,
            run_index=self.plan.first_run + self._index[run.key],
            name=self._name(run, attempt),
            session=self._session(run.measurement),
        )
        if not run.needs:
            return m
        source, radius = self.journal.done[run.needs], self._radius(run.needs)
        assert radius is not None, f"{run.key} is not ready"
        return replace(m, effective_rolling_radius=radius, r_e_source=source.files[-1])

    def _session(self, m: Measurement) -> dict[str, Any]:
        """Facts of the session, with the road that loaded tires have rolled on the paper so far
        [m]."""
        before = m.session.get("sliding_distance", 0.0)
        return {**m.session, "sliding_distance": round(before + self.journal.travel, 3)}

    def _name(self, run: PlannedRun, attempt: int) -> str:
        """Name by Appendix F, then with _r02, ...: unique for each run and attempt."""
        base = self._names[run.key]
        same = [key for key, name in self._names.items() if name == base]
        number = 1 + same.index(run.key) + (attempt - 1) * len(same) + self.plan.first_run
        return base if number == 1 else f"{base}_r{number:02d}"

    def _earlier(self, run: PlannedRun) -> tuple[list[float], ...]:
        """Fx profiles of good runs with the same slip and condition, any start or repeat."""
        same = _sameness(run.measurement)
        found = []
        for other in self.plan.runs:
            done = self.journal.done.get(other.key)
            if done is None or not done.facts.get("good") or "profile" not in done.facts:
                continue
            if other.key != run.key and _sameness(other.measurement) == same:
                found.append(done.facts["profile"])
        return tuple(found)


def _sameness(m: Measurement) -> Measurement:
    return replace(m, start=1, repeat=0, run_index=0, notes="", name="")


def unwritten(folder: Path, job: Job, journal: Journal) -> Path | None:
    """Complete bag of this run that is not in the journal, or None."""
    written = {name for done in journal.done.values() for name in done.files}
    for path in sorted(folder.glob(f"{job.measurement.name}*")):
        if path.name in written or not (path / FILE_NAME).exists():
            continue
        record = load_record(path)
        if record.status == "complete" and record.run_index == job.measurement.run_index:
            return path
    return None
