# SPDX-License-Identifier: Apache-2.0
"""The order of a plan's runs: a reference run first and every N runs, r_e before what needs it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from flatplank_control.runner.measurement import ON_THE_ROAD, Measurement

_OF_THE_CONDITION = (
    "tire", "fz", "pressure", "alpha_deg", "gamma_deg", "wheel_camber_deg",
)  # fmt: skip
RADIUS = "r_e."
"""how the keys of further runs begin that give an effective rolling radius"""
_OF_THE_DAY = (
    "serial", "operator", "session", "et_value", "adapter_thickness", "hold_load", "end_position",
)  # fmt: skip


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
    lines: Mapping[str, int] = field(default_factory=dict, compare=False, repr=False)
    """line of each of its keys"""

    def line_of(self, key: str) -> int:
        """Line of a key, else of the run itself."""
        return self.lines.get(key, self.line)


def condition(m: Measurement) -> tuple:
    """What one effective rolling radius holds for."""
    return tuple(getattr(m, name) for name in _OF_THE_CONDITION)


def with_reference(
    runs: Sequence[PlannedRun], base: PlannedRun, every: int
) -> Iterator[PlannedRun]:
    """The reference run before the first and after every N runs: what the paper has lost."""
    for k, run in enumerate(runs):
        if k % every == 0:
            yield replace(base, key=f"{base.key}.{k // every}")
        yield run


def with_radius(runs: Iterable[PlannedRun]) -> Iterator[PlannedRun]:
    """Before the first run of a condition that rolls by its wheel's speed comes the one that
    gives its r_e: a free-rolling run of the plan, else a further one."""
    runs = list(runs)
    makers: dict[tuple, PlannedRun] = {}
    for run in runs:
        m = run.measurement
        # r_e of the slip control is that of a driven wheel
        if m.measurement == "free_rolling" and m.flexplates and run.role == "run":
            makers.setdefault(condition(m), run)
    made: set[str] = set()
    for run in runs:
        if run.key in made:
            continue
        if run.measurement.measurement not in ON_THE_ROAD:
            made.add(run.key)
            yield run
            continue
        maker = makers.setdefault(condition(run.measurement), _radius_run(run))
        if maker.key not in made:
            made.add(maker.key)
            yield replace(maker, role="radius")
        yield replace(run, needs=maker.key)


def _radius_run(run: PlannedRun) -> PlannedRun:
    kept = {k: getattr(run.measurement, k) for k in (*_OF_THE_CONDITION, *_OF_THE_DAY)}
    lines = {k: v for k, v in run.lines.items() if k in kept}
    free = Measurement(measurement="free_rolling", **kept)
    return PlannedRun(f"{RADIUS}{run.key}", free, run.line, lines=lines)
