# SPDX-License-Identifier: Apache-2.0
"""A campaign plan: YAML with lists, expanded to measurements that are checked one by one."""

from __future__ import annotations

import hashlib
import itertools
import random
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

from flatplank_control.runner.campaign.checks import refuse
from flatplank_control.runner.campaign.located import Located, load
from flatplank_control.runner.campaign.quality import Limits, limits_from
from flatplank_control.runner.campaign.tires import TireEntry, known_tires
from flatplank_control.runner.measurement import ON_THE_ROAD, Measurement, from_mapping
from flatplank_hw.params import nearest

FORMAT = "flatplank-plan/1"
ORDERS = ("as_written", "random")
RADII = ("measured", "given")
SESSION = ("room_temperature", "paper_batch", "sliding_distance", "pressure_after", "rim", "notes")
"""facts of the session that a run record keeps beside its own fields"""
_MEASUREMENT = {f.name for f in fields(Measurement)}
_WHOLE = ("waveform_parameters", "profile_parameters", "session")
"""keys whose value is no list of alternatives"""


@dataclass(frozen=True)
class PlannedRun:
    """One run of a campaign."""

    key: str
    """identity within the plan, for resume"""
    measurement: Measurement
    line: int
    """in the plan, where it comes from"""
    role: str = "run"
    """run, radius (gives r_e to others) or reference (wear)"""
    needs: str = ""
    """key of the run that gives its effective rolling radius"""


@dataclass(frozen=True)
class CampaignPlan:
    """An expanded plan, in the order in which it is made."""

    name: str
    where: str
    digest: str
    """of the text: what a resume must find again"""
    tire: TireEntry
    runs: tuple[PlannedRun, ...]
    attempts: int = 2
    """a run that fails its quality is made at most so often"""
    quality: Limits = field(default_factory=Limits)


class PlanError(ValueError):
    """All that is wrong with a plan, one line each."""

    def __init__(self, problems: Sequence[str]) -> None:
        super().__init__("\n".join(problems))
        self.problems = tuple(problems)


def is_campaign(data: Any) -> bool:
    """Whether YAML data is a campaign plan, not a single measurement."""
    return isinstance(data, Mapping) and data.get("format") == FORMAT


def load_plan(path: str | Path) -> CampaignPlan:
    """The plan of a file; PlanError names file, line and reason."""
    try:
        text = Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise PlanError([f"{path}: cannot be read ({error})"]) from None
    return plan_from_text(text, str(path))


def plan_from_text(text: str, where: str) -> CampaignPlan:
    """The plan of a text; PlanError lists every line that cannot be done."""
    try:
        data = load(text, where)
    except ValueError as error:
        raise PlanError([str(error)]) from None
    return _Builder(data, where, hashlib.sha256(text.encode()).hexdigest()[:16]).build()


class _Builder:
    """Reads, expands, orders; collects problems instead of stopping at the first."""

    KEYS = frozenset(
        [
            "format",
            "name",
            "tire",
            "order",
            "seed",
            "attempts",
            "r_e",
            "reference",
            "quality",
            "common",
            "runs",
            "set_up",
            "session",
            "serial",
            "operator",
        ]
    )

    def __init__(self, data: Any, where: str, digest: str) -> None:
        self.data, self.where, self.digest = data, where, digest
        self.problems: list[str] = []

    def build(self) -> CampaignPlan:
        data = self.data
        if not isinstance(data, Located) or data.get("format") != FORMAT:
            raise PlanError([f"{self.where}: not a plan; expected 'format: {FORMAT}'"])
        self._keys(data, self.KEYS, "")
        tire = self._tire(data)
        self._choice(data, "order", ORDERS)
        self._choice(data, "r_e", RADII)
        limits = self._limits(data)
        runs = list(self._expand(data)) if tire else []
        if not runs and not self.problems:
            self._say(data.line_of("runs"), "runs: nothing to measure; give at least one block")
        if tire:
            self._check_all(runs, tire)
        if self.problems:
            raise PlanError(self.problems)
        ordered = self._ordered(runs)
        return CampaignPlan(
            str(data.get("name") or Path(self.where).stem), self.where, self.digest, tire,
            tuple(self._with_reference(self._with_radius(ordered))),
            int(data.get("attempts", 2)), limits,
        )  # fmt: skip

    # reading
    def _say(self, line: int, text: str) -> None:
        problem = f"{self.where}:{line}: {text}"
        if problem not in self.problems:
            self.problems.append(problem)

    def _keys(self, data: Located, known: frozenset[str] | set[str], prefix: str) -> None:
        for key in data:
            if key not in known:
                self._say(data.line_of(key), f"{prefix}unknown key '{key}'{nearest(key, known)}")

    def _choice(self, data: Located, key: str, allowed: Sequence[str]) -> None:
        value = data.get(key, allowed[0])
        if value not in allowed:
            self._say(data.line_of(key), f"{key} is '{value}'{nearest(str(value), allowed)}")

    def _tire(self, data: Located) -> TireEntry | None:
        name = str(data.get("tire", ""))
        known = known_tires()
        if name not in known:
            self._say(data.line_of("tire"), f"unknown tire '{name}'{nearest(name, known)}")
            return None
        return known[name]

    def _limits(self, data: Located) -> Limits:
        try:
            return limits_from(data.get("quality") or {})
        except ValueError as error:
            self._say(data.line_of("quality"), f"quality: {error}")
            return Limits()

    # expanding
    def _expand(self, data: Located) -> Iterator[PlannedRun]:
        common = data.get("common") or {}
        blocks = data.get("runs")
        if not isinstance(blocks, list):
            self._say(data.line_of("runs"), "runs: expected a list of blocks")
            return
        for number, block in enumerate(blocks):
            if not isinstance(block, Located):
                self._say(data.line_of("runs"), f"runs: block {number + 1} is no mapping")
                continue
            yield from self._block(number, {**common}, block)

    def _block(self, number: int, common: dict, block: Located) -> Iterator[PlannedRun]:
        self._keys(block, _MEASUREMENT | {"repeats"}, "")
        values = {**common, **{k: v for k, v in block.items() if k in _MEASUREMENT}}
        varied = {k: v for k, v in values.items() if isinstance(v, list) and k not in _WHOLE}
        fixed = {k: _plain(v) for k, v in values.items() if k not in varied}
        repeats = block.get("repeats", 1)
        if not isinstance(repeats, int) or repeats < 1:
            self._say(block.line_of("repeats"), f"repeats is {repeats!r}; give 1 or more")
            return
        combinations = itertools.product(*varied.values(), range(repeats))
        for k, combination in enumerate(combinations):
            own = dict(zip(varied, combination, strict=False))
            run = self._run(f"{number}.{k}", fixed | own, combination[-1], block)
            if run:
                yield run

    def _run(self, key: str, values: dict, repeat: int, block: Located) -> PlannedRun | None:
        data = self.data
        about = {"tire": data.get("tire"), "session": dict(data.get("session") or {})}
        about |= {k: str(data[k]) for k in ("serial", "operator") if k in data}
        try:
            m = from_mapping({**about, "repeat": repeat, **values}, "")
        except ValueError as error:
            text = re.sub(r"^: (measurement [^:]*: )?", "", str(error))
            line = next(
                (n for k, n in block.lines.items() if k in re.findall(r"\w+", text)), block.line
            )
            self._say(line, text)
            return None
        return PlannedRun(key, m, block.line)

    def _check_all(self, runs: Sequence[PlannedRun], tire: TireEntry) -> None:
        """Reasons against runs, each said once with the line of its block and key."""
        blocks = {b.line: b for b in self.data.get("runs") or [] if isinstance(b, Located)}
        said = set()
        for run in runs:
            for key, reason in refuse(run.measurement, tire, self.data.get("set_up") or {}):
                line = blocks[run.line].line_of(key)
                if (line, reason) not in said:
                    said.add((line, reason))
                    self._say(line, reason)

    # ordering
    def _ordered(self, runs: list[PlannedRun]) -> list[PlannedRun]:
        if self.data.get("order") == "random":
            random.Random(self.data.get("seed", 0)).shuffle(runs)
        return runs

    def _with_radius(self, runs: list[PlannedRun]) -> Iterator[PlannedRun]:
        """Before the first slip run of a condition comes the run that gives its r_e."""
        if self.data.get("r_e", RADII[0]) == "given":
            yield from runs
            return
        makers: dict[tuple, PlannedRun] = {}
        for run in runs:
            if run.measurement.measurement == "free_rolling":
                makers.setdefault(condition(run.measurement), run)
        made: set[str] = set()
        for run in runs:
            if run.key in made:
                continue
            if run.measurement.measurement not in ON_THE_ROAD:
                made.add(run.key)
                yield run
                continue
            maker = makers.get(condition(run.measurement))
            if maker is None:
                maker = makers[condition(run.measurement)] = _radius_run(run)
            if maker.key not in made:
                made.add(maker.key)
                yield PlannedRun(maker.key, maker.measurement, maker.line, "radius")
            yield PlannedRun(run.key, run.measurement, run.line, "run", maker.key)

    def _with_reference(self, runs: Iterator[PlannedRun]) -> Iterator[PlannedRun]:
        """A reference run before the first and after every N runs: what the paper has lost."""
        spec = self.data.get("reference")
        runs = list(runs)
        if not spec:
            yield from runs
            return
        every = int(spec.get("every", 20))
        values = {k: v for k, v in spec.items() if k != "every"}
        base = from_mapping({"tire": self.data["tire"], **values}, f"{self.where}: reference")
        needs = next((r.key for r in runs if r.role == "radius"
                      and condition(r.measurement) == condition(base)), "")  # fmt: skip
        for k, run in enumerate(runs):
            yield run
            ready = not needs or any(r.key == needs for r in runs[: k + 1])
            if ready and (k + 1) % every == 0 and k + 1 < len(runs):
                number = (k + 1) // every
                yield PlannedRun(
                    f"reference.{number}", base, self.data.line_of("reference"), "reference", needs
                )


def _plain(value: Any) -> Any:
    return dict(value) if isinstance(value, Located) else value


def condition(m: Measurement) -> tuple:
    """What one effective rolling radius holds for."""
    return (m.tire, m.fz, m.pressure, m.alpha_deg, m.gamma_deg)


def _radius_run(run: PlannedRun) -> PlannedRun:
    m = run.measurement
    same = {k: getattr(m, k) for k in ("tire", "fz", "pressure", "alpha_deg", "gamma_deg")}
    about = {k: getattr(m, k) for k in ("serial", "operator", "session", "end_position")}
    free = Measurement(measurement="free_rolling", **same, **about)
    return PlannedRun(f"r_e.{run.key}", free, run.line)
