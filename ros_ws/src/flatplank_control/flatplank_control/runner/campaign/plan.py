# SPDX-License-Identifier: Apache-2.0
"""Campaign plans: YAML with lists, expanded to measurements that are checked one by one."""

from __future__ import annotations

import hashlib
import itertools
import random
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

from flatplank_control.runner.campaign.checks import SetUp, problems_of_run
from flatplank_control.runner.campaign.order import RADIUS, PlannedRun, with_radius, with_reference
from flatplank_control.runner.campaign.quality import Limits
from flatplank_control.runner.campaign.reading import Located, PlanReader, load_with_lines, plain
from flatplank_control.runner.campaign.tires import TireEntry, known_tires
from flatplank_control.runner.measurement import (
    ON_THE_ROAD,
    Measurement,
    MeasurementError,
    from_mapping,
)
from flatplank_data.errors import FlatplankError, RecordingError
from flatplank_data.files import read_text
from flatplank_data.limits import LIMITS, PILLAR_DEG
from flatplank_data.names import nearest_hint
from flatplank_data.naming import check_name
from flatplank_hw.share import config_file

FORMAT = "flatplank-plan/1"
KEYS = (
    "format", "name", "tire", "serial", "operator", "session", "order", "seed", "attempts", "r_e",
    "reference", "set_up", "quality", "common", "first_run", "runs",
)  # fmt: skip
ORDERS = ("as_written", "random")
RADII = ("measured", "given")
SET_UP = ("blocked_wheel_angles_deg", "steer_limit_deg")
SESSION: dict[str, tuple[float, float] | None] = {
    "room_temperature": (-20.0, 60.0),
    "paper_batch": None,
    "sliding_distance": (0.0, 1e6),
    "rim": None,
    "notes": None,
}
"""further fact of the session in a run record -> its range; None: text"""
NOT_OF_A_BLOCK = {
    **dict.fromkeys(("tire", "serial", "operator", "session"), "write it once, at the top"),
    **dict.fromkeys(("name", "run_index"), "leave it out: the run gets its own"),
    "repeat": "give repeats",
}
"""field of a measurement that is not allowed in a block -> remedy"""
OF_A_RUN = frozenset(f.name for f in fields(Measurement)) - frozenset(NOT_OF_A_BLOCK)
OF_A_BLOCK = OF_A_RUN | {"repeats"}
_LIMITS = tuple(f.name for f in fields(Limits))
RADIUS_RUN = "the run that gives r_e (a free_rolling block of yours takes its place): "
MOST_REPEATS = 1000
_WHOLE = ("waveform_parameters", "profile_parameters")
"""keys whose list value is no list of alternatives"""


@dataclass(frozen=True)
class CampaignPlan:
    """An expanded plan, with its runs in order of execution."""

    name: str
    where: str
    digest: str
    """digest of the text; must be the same at a resume"""
    tire: TireEntry
    runs: tuple[PlannedRun, ...]
    attempts: int = 2
    """largest number of attempts for a run that fails its quality limits"""
    quality: Limits = field(default_factory=Limits)
    first_run: int = 0
    """number of earlier runs in the folder; run numbers and names continue from there"""


class PlanError(FlatplankError):
    """Faults of a plan, one line each."""

    def __init__(self, problems: Sequence[str]) -> None:
        super().__init__("\n".join(problems))
        self.problems = tuple(problems)
        self.args = (self.problems,)

    def __str__(self) -> str:
        return "\n".join(self.problems)


def shipped_plans() -> dict[str, Path]:
    """The packaged plans: name -> file."""
    one = config_file("flatplank_control", "tires.yaml")
    files = sorted((one.parent / "plans").glob("*.yaml")) if one else []
    return {path.stem: path for path in files}


def is_campaign(data: Any) -> bool:
    """True when YAML data is a campaign plan, false for a single measurement."""
    return isinstance(data, Mapping) and data.get("format") == FORMAT


def load_plan(path: str | Path) -> CampaignPlan:
    """Read the plan in a file; PlanError names file, line and reason."""
    try:
        text = read_text(path)
    except ValueError as error:
        raise PlanError([str(error)]) from None
    return plan_from_text(text, str(path))


def plan_from_text(text: str, where: str) -> CampaignPlan:
    """Read the plan in a text; PlanError lists every wrong line."""
    try:
        data = load_with_lines(text, where)
    except ValueError as error:
        raise PlanError([str(error)]) from None
    return _Builder(data, where, hashlib.sha256(text.encode()).hexdigest()[:16]).build()


class _Builder:
    """Reads, expands and orders a plan; collects problems instead of stopping at the first."""

    def __init__(self, data: Any, where: str, digest: str) -> None:
        if not isinstance(data, Located) or data.get("format") != FORMAT:
            raise PlanError([f"{where}: not a plan; expected 'format: {FORMAT}'"])
        self.data, self.where, self.digest = data, where, digest
        self.read = PlanReader(where)

    def build(self) -> CampaignPlan:
        data, read = self.data, self.read
        read.check_keys(data, KEYS)
        name, tire, limits, set_up = self._name(), self._tire(), self._limits(), self._set_up()
        attempts = read.integer(data, "attempts", 2, least=1)
        first = read.integer(data, "first_run", 0, least=0)
        common = read.section(data, "common", OF_A_BLOCK, NOT_OF_A_BLOCK)
        if tire is None:
            raise PlanError(read.problems)
        about = self._about(tire)
        runs = list(self._in_order(list(self._expand(about, common)), about, common))
        for run in runs:
            for key, reason in problems_of_run(run.measurement, tire, set_up):
                own = run.key.startswith(RADIUS) and key not in run.lines
                read.add_problem(run.line_of(key), f"{RADIUS_RUN if own else ''}{reason}")
        if read.problems:
            raise PlanError(read.problems)
        return CampaignPlan(
            name, self.where, self.digest, tire, tuple(runs), attempts, limits, first
        )

    # reading
    def _name(self) -> str:
        name = self.read.text(self.data, "name", Path(self.where).stem)
        try:
            return check_name(name)
        except RecordingError as error:
            self.read.add_problem(self.data.line_of("name"), f"name: {error}")
            return name

    def _tire(self) -> TireEntry | None:
        name, known = str(self.data.get("tire", "")), known_tires()
        if name not in known:
            line = self.data.line_of("tire")
            self.read.add_problem(line, f"unknown tire '{name}'{nearest_hint(name, known)}")
        return known.get(name)

    def _limits(self) -> Limits:
        section = self.read.section(self.data, "quality", _LIMITS)
        return Limits(**{k: self.read.positive(section, k) for k in section if k in _LIMITS})

    def _set_up(self) -> SetUp:
        section = self.read.section(self.data, "set_up", SET_UP)
        blocked, steer = SET_UP
        limits = (0.0, LIMITS["steer_deg"].high)
        return SetUp(
            self.read.spans(section, blocked),
            self.read.number(section, steer, PILLAR_DEG, limits),
        )

    def _about(self, tire: TireEntry) -> dict[str, Any]:
        """Values of all runs, and defaults for values missing in a block."""
        data, read = self.data, self.read
        session = read.section(data, "session", SESSION)
        facts = {
            key: read.number(session, key, span[0], span) if span else read.text(session, key)
            for key, span in SESSION.items()
            if key in session
        }
        nominal = {"tire": tire.name, "fz": tire.nominal_load, "pressure": tire.nominal_pressure}
        return {
            **nominal,
            "serial": read.text(data, "serial"),
            "operator": read.text(data, "operator"),
            "session": facts,
        }

    # expanding
    def _expand(self, about: dict[str, Any], common: Located) -> Iterator[PlannedRun]:
        blocks = self.data.get("runs")
        if not isinstance(blocks, list) or not blocks:
            line = self.data.line_of("runs")
            self.read.add_problem(line, "runs: nothing to measure; give a list of blocks")
            return
        for number, block in enumerate(blocks):
            if not isinstance(block, Located):
                line = self.data.line_of("runs")
                self.read.add_problem(
                    line, f"runs: block {number + 1} is {block!r}; give keys and values"
                )
                continue
            self.read.check_keys(block, OF_A_BLOCK, "", NOT_OF_A_BLOCK)
            lines = common.lines | block.lines
            yield from self._block(number, about, _known({**common, **block}), lines, block.line)

    def _block(
        self, number: int, about: dict, values: dict, lines: Mapping[str, int], line: int
    ) -> Iterator[PlannedRun]:
        repeats = values.pop("repeats", 1)
        whole = isinstance(repeats, int) and not isinstance(repeats, bool)
        if not whole or not 1 <= repeats <= MOST_REPEATS:
            say = f"repeats is {plain(repeats)!r}; give a whole number of 1 .. {MOST_REPEATS}"
            self.read.add_problem(lines["repeats"], say)
            return
        varied = {k: v for k, v in values.items() if isinstance(v, list) and k not in _WHOLE}
        for key in (k for k, v in varied.items() if not v):
            self.read.add_problem(
                lines[key], f"{key} is an empty list; give values, or leave it out"
            )
        combinations = itertools.product(*varied.values(), range(repeats))
        for k, combination in enumerate(combinations):
            own = {**values, **dict(zip(varied, combination, strict=False))}
            m = self._measurement({**about, **own, "repeat": combination[-1]}, lines, line)
            if m:
                yield PlannedRun(f"{number}.{k}", m, line, lines=lines)

    def _measurement(
        self, values: Mapping[str, Any], lines: Mapping[str, int], line: int
    ) -> Measurement | None:
        try:
            m = from_mapping({k: plain(v) for k, v in values.items()}, self.where)
        except MeasurementError as error:
            self.read.add_problem(lines.get(error.key, line), error.reason)
            return None
        no_radius = m.measurement in ON_THE_ROAD and "effective_rolling_radius" not in values
        if no_radius and self.data.get("r_e") == "given":
            self.read.add_problem(line, "r_e is given: write effective_rolling_radius [m] here")
        return m

    # ordering
    def _in_order(
        self, runs: list[PlannedRun], about: dict[str, Any], common: Located
    ) -> Iterable[PlannedRun]:
        data, read = self.data, self.read
        seed = read.integer(data, "seed", 0, least=0)
        if read.choice(data, "order", ORDERS) == "random":
            random.Random(seed).shuffle(runs)
        spec = read.section(data, "reference", OF_A_RUN | {"every"}, NOT_OF_A_BLOCK)
        every = read.integer(spec, "every", 20, least=1)
        base = self._reference(spec, about, common) if spec else None
        all_runs = with_reference(runs, base, every) if base else runs
        measured = read.choice(data, "r_e", RADII) == "measured"
        return with_radius(all_runs) if measured else all_runs

    def _reference(
        self, spec: Located, about: dict[str, Any], common: Located
    ) -> PlannedRun | None:
        """Reference run; missing values are those of `common`, from a list the first one."""
        same = {k: v[0] if isinstance(v, list) and v else v for k, v in common.items()}
        values = {k: v for k, v in {**same, **spec}.items() if k in OF_A_RUN}
        line, lines = self.data.line_of("reference"), common.lines | spec.lines
        m = self._measurement({**about, **values}, lines, line)
        return PlannedRun("reference", m, line, "reference", lines=lines) if m else None


def _known(values: Mapping[str, Any]) -> dict[str, Any]:
    return {k: v for k, v in values.items() if k in OF_A_BLOCK}
