# SPDX-License-Identifier: Apache-2.0
"""The bench of an investigation: each batch is a campaign in one folder, judged like any other."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from functools import lru_cache
from pathlib import Path

from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.investigation.loop import BatchResult
from flatplank_analysis.investigation.planner import Price
from flatplank_analysis.investigation.settings import Candidate, Setting, seed_of
from flatplank_control.bench.results import write_campaign
from flatplank_control.runner.campaign import Journal, plan_from_text
from flatplank_control.runner.campaign.plan import FORMAT, CampaignPlan
from flatplank_control.runner.campaign.tires import TireEntry
from flatplank_control.runner.dry_run import dry_run
from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError, NothingUsableError
from flatplank_data.journals import SUFFIX
from flatplank_data.yaml_text import dump_yaml

SET_UP = {"fz": 0.0, "pressure": 5.0, "alpha_deg": 2.0}
"""setting -> time to change it by hand, in addition to that of the dry run [min]: the tire is
inflated and settles, the steering is unlocked"""
Radii = Mapping[tuple[float, float, float], float]
"""condition of a setting -> effective rolling radius [m], where known"""


def batch_name(number: int) -> str:
    """Name of a batch, for its plan and its journal."""
    return f"batch_{number:02d}"


def plan_text(
    name: str, tire: str, settings: Sequence[Setting], radii: Radii, first_run: int
) -> str:
    """Text of a plan with settings of one condition; it measures r_e where it is unknown."""
    radius = radii.get(settings[0].condition)
    given = {} if radius is None else {"effective_rolling_radius": radius}
    plan = {
        "format": FORMAT, "name": name, "tire": tire, "attempts": 1, "first_run": first_run,
        "r_e": "measured" if radius is None else "given",
        "runs": [{"measurement": "slip", **s.to_dict(), **given} for s in settings],
    }  # fmt: skip
    return dump_yaml(plan)


def settings_of(plan: CampaignPlan) -> dict[str, Setting]:
    """key of a slip run in a plan -> its setting."""
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
    """Cost of a batch [min]: its dry run, with the plank's return before the first run, and the
    changes of settings from the present state of the bench."""
    text = plan_text("price", tire, (settings[0], *settings), radii, 0)
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
    """Duration of the dry run [min] without its first run, for which the plank need not return."""
    times = list(dry_run(plan_from_text(text, "batch")).durations.values())
    return sum(times[1:]) / 60.0


REPORT = "investigation"
"""folder of the report page; contains no run"""
Execute = Callable[[CampaignPlan, str, float], None]
"""(plan, its text, minutes left after it) -> None; makes the runs of the plan in the folder"""


class CampaignBench:
    """Bench of an investigation; `execute` makes a plan or its missing runs, and the journal has
    the outcome."""

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
        """Files of the existing slip runs."""
        return [i.file for i in campaign_so_far(self.folder).infos if i.measurement == "slip"]

    def session(self, files: Collection[str]) -> Session:
        """Session with these runs."""
        wanted = set(files)
        campaign = campaign_so_far(self.folder).where(lambda info: info.file in wanted)
        if lost := wanted - {r.info.file for r in campaign.runs}:
            raise FlatplankError(
                "a run of the investigation is gone", str(self.folder / min(lost)),
                "put it back, or begin in another folder",
            )  # fmt: skip
        return Session.of(campaign, self.effects)

    def seed(self) -> Candidate:
        """The first settings: six runs at the nominal load and pressure of the tire."""
        return seed_of(self.tire.nominal_load, self.tire.nominal_pressure)

    def price(self, candidate: Candidate) -> Price:
        """Cost of a candidate [min], and the settings that change from the last run."""
        radii = self._known()[0]
        try:
            return price_of(self.tire.name, candidate.settings, radii, self._stands)
        except ValueError:  # not possible on this bench
            return Price(float("inf"), 0)

    def plan(self, number: int, candidate: Candidate) -> str:
        """Text of the plan for a candidate."""
        radii, first = self._known()
        name = batch_name(number)
        return plan_text(name, self.tire.name, candidate.settings, radii, first)

    def measure(self, number: int, plan: str, left: float) -> BatchResult:
        """Make the batch; returns the files of good runs and the settings of the others."""
        parsed = plan_from_text(plan, batch_name(number))
        self.execute(parsed, plan, left)
        journal = Journal(self.folder / f"{parsed.name}{SUFFIX}", parsed.name, parsed.digest)
        good, back, bad = [], [], []
        for key, setting in settings_of(parsed).items():
            done = journal.done.get(key)
            self._stands = setting
            if done and done.valid_file and done.facts.get("good") and not done.skipped:
                good.append(done.valid_file)
            else:
                back.append(setting)
                bad += done.files if done else []
        if bad:
            write_campaign(self.folder, self.tire.name, [], bad)
        self._radii = None
        return BatchResult(tuple(good), tuple(back))

    _radii: tuple[dict[tuple[float, float, float], float], int] | None = None

    def _known(self) -> tuple[dict[tuple[float, float, float], float], int]:
        """Known rolling radii by condition, and the number of the next run."""
        if self._radii is None:
            infos = campaign_so_far(self.folder).infos
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


def campaign_so_far(folder: Path) -> Campaign:
    """The campaign of a folder; an empty one when there are no runs yet."""
    try:
        return Campaign.load(folder)
    except NothingUsableError:
        return Campaign(str(folder), [])
