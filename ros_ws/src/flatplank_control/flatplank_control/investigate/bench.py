# SPDX-License-Identifier: Apache-2.0
"""The bench of an investigation: batches are campaigns in one folder, judged as any other."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from functools import lru_cache
from pathlib import Path

import yaml

from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.investigation.loop import Made
from flatplank_analysis.investigation.planner import Price
from flatplank_analysis.investigation.settings import Candidate, Setting, seed_of
from flatplank_control.bench.results import write_campaign
from flatplank_control.runner.campaign import SUFFIX, Journal, plan_from_text
from flatplank_control.runner.campaign.plan import FORMAT, CampaignPlan
from flatplank_control.runner.campaign.tires import TireEntry
from flatplank_control.runner.dry_run import dry_run
from flatplank_control.runner.steps import PlanFailed
from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError, NothingUsableError

SET_UP = {"fz": 0.0, "pressure": 5.0, "alpha_deg": 2.0}
"""what changes of a condition take beside the dry run, in which a simulated operator has his hands
at everything [min]: air and its settling, the steering's lock"""
Radii = Mapping[tuple[float, float, float], float]
"""condition of a setting -> effective rolling radius [m], where it is known"""


def batch_name(number: int) -> str:
    """Of a plan and its journal."""
    return f"batch_{number:02d}"


def text_of(
    name: str, tire: str, settings: Sequence[Setting], radii: Radii, first_run: int
) -> str:
    """A plan of settings of one condition; r_e is measured where it is not known."""
    radius = radii.get(settings[0].condition)
    given = {} if radius is None else {"effective_rolling_radius": radius}
    plan = {
        "format": FORMAT, "name": name, "tire": tire, "attempts": 1, "first_run": first_run,
        "r_e": "measured" if radius is None else "given",
        "runs": [{"measurement": "slip", **s.plain(), **given} for s in settings],
    }  # fmt: skip
    return yaml.safe_dump(plan, sort_keys=False)


def settings_of(plan: CampaignPlan) -> dict[str, Setting]:
    """The settings of a plan's slip runs by key."""
    out = {}
    for run in plan.runs:
        m = run.measurement
        if m.measurement == "slip":
            out[run.key] = Setting(
                m.kappa, m.start, m.step_position, m.fz, m.pressure, m.alpha_deg
            )
    return out


def price_of(
    tire: str, settings: Sequence[Setting], radii: Radii, stands: Setting | None
) -> Price:
    """Minutes of a batch's dry run, the plank's way back before its first run with it, and of
    what is changed from how the bench stands."""
    text = text_of("price", tire, (settings[0], *settings), radii, 0)
    before, minutes, changes = stands, _dry_minutes(text), 0
    for s in settings:
        for name, each in SET_UP.items():
            if before is not None and getattr(s, name) != getattr(before, name):
                minutes += each
                changes += 1
        before = s
    return Price(minutes, changes)


@lru_cache(maxsize=512)
def _dry_minutes(text: str) -> float:
    """Without the first run, which finds the plank at the front."""
    times = list(dry_run(plan_from_text(text, "batch")).durations.values())
    return sum(times[1:]) / 60.0


REPORT = "investigation"
"""folder of the page; no run"""
Execute = Callable[[CampaignPlan, str, float], None]
"""has a plan (its text, too) made in the folder; the last: minutes of the budget after it"""


class CampaignBench:
    """`execute` makes a plan, or what is lacking of it; its journal says what came of it."""

    def __init__(
        self,
        folder: Path,
        tire: TireEntry,
        execute: Execute,
        effects: tuple[str, ...] = (),
    ) -> None:
        self.folder, self.tire, self.execute = folder, tire, execute
        self.effects = effects
        self._stands: Setting | None = None

    def files(self) -> list[str]:
        """Slip runs that are there."""
        return [r.info.file for r in self._campaign().runs if r.info.measurement == "slip"]

    def session(self, files: Collection[str]) -> Session:
        """These runs."""
        wanted = set(files)
        campaign = self._campaign().where(lambda info: info.file in wanted)
        if lost := wanted - {r.info.file for r in campaign.runs}:
            raise FlatplankError(
                "a run of the investigation is gone", str(self.folder / min(lost)),
                "put it back, or begin in another folder",
            )  # fmt: skip
        return Session.of(campaign, self.effects)

    def seed(self) -> Candidate:
        """Six runs at the nominal load and pressure of the tire."""
        return seed_of(self.tire.nominal_load, self.tire.nominal_pressure)

    def price(self, candidate: Candidate) -> Price:
        """Minutes, and what is changed from the last run."""
        radii = self._known()[0]
        try:
            return price_of(self.tire.name, candidate.settings, radii, self._stands)
        except (PlanFailed, ValueError):  # the bench cannot make it
            return Price(float("inf"), 0)

    def plan(self, number: int, candidate: Candidate) -> str:
        """The plan's text."""
        radii, first = self._known()
        name = batch_name(number)
        return text_of(name, self.tire.name, candidate.settings, radii, first)

    def measure(self, number: int, plan: str, left: float) -> Made:
        """Have the batch made; what the journal flags or skips is handed back."""
        parsed = plan_from_text(plan, batch_name(number))
        self.execute(parsed, plan, left)
        journal = Journal(self.folder / f"{parsed.name}{SUFFIX}", parsed.name, parsed.digest)
        good, back, bad = [], [], []
        for key, setting in settings_of(parsed).items():
            done = journal.done.get(key)
            self._stands = setting
            if done and done.counts and done.facts.get("good") and not done.skipped:
                good.append(done.counts)
            else:
                back.append(setting)
                bad += done.files if done else []
        if bad:
            write_campaign(self.folder, self.tire.name, [], bad)
        self._radii = None
        return Made(tuple(good), tuple(back))

    _radii: tuple[dict[tuple[float, float, float], float], int] | None = None

    def _known(self) -> tuple[dict[tuple[float, float, float], float], int]:
        """Rolling radii by condition, and the number of the next run."""
        if self._radii is None:
            infos = self._campaign().infos
            radii = {
                (float(round(i.fz)), round(i.pressure, 3), round(i.alpha_deg, 3)):
                    float(i.effective_rolling_radius)
                for i in infos
                if i.measurement == "slip" and i.effective_rolling_radius > 0.0
                and i.gamma_deg == 0.0
                and i.fz == i.fz
            }  # fmt: skip
            there = [
                p for p in self.folder.glob("*")
                if p.suffix == ".parquet" or (p.is_dir() and p.name != REPORT)
            ]  # fmt: skip
            last = max((i.run_index for i in infos), default=-1)
            self._radii = radii, max(last + 1, len(there))
        return self._radii

    def _campaign(self) -> Campaign:
        """What is there; nothing is no fault."""
        try:
            return Campaign.load(self.folder)
        except NothingUsableError:
            return Campaign(str(self.folder), [])
