# SPDX-License-Identifier: Apache-2.0
"""Orders the runs of a plan: a reference run first and every N runs, r_e where it is needed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from flatplank_control.runner.measurement import ON_THE_ROAD, Measurement

_OF_THE_CONDITION = (
    "tire", "fz", "pressure", "alpha_deg", "gamma_deg", "wheel_camber_deg",
)  # fmt: skip
RADIUS = "r_e."
"""prefix of the keys of added runs that determine an effective rolling radius"""
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
    """line in the plan that defines it"""
    role: str = "run"
    """run, radius (determines r_e for others) or reference (wear)"""
    needs: str = ""
    """key of the run that determines its effective rolling radius"""
    lines: Mapping[str, int] = field(default_factory=dict, compare=False, repr=False)
    """key -> line in the plan"""

    def line_of(self, key: str) -> int:
        """Line of a key, else of the run itself."""
        return self.lines.get(key, self.line)


def radius_condition(m: Measurement) -> tuple:
    """Condition for which one effective rolling radius is valid."""
    return tuple(getattr(m, name) for name in _OF_THE_CONDITION)


def with_reference(
    runs: Sequence[PlannedRun], base: PlannedRun, every: int
) -> Iterator[PlannedRun]:
    """Add the reference run before the first and after every N runs; it shows the wear of the
    paper."""
    for k, run in enumerate(runs):
        if k % every == 0:
            yield replace(base, key=f"{base.key}.{k // every}")
        yield run


def with_radius(runs: Iterable[PlannedRun]) -> Iterator[PlannedRun]:
    """Put the run that determines r_e before the first run of a condition with a driven wheel: a
    free-rolling run of the plan, else an added one."""
    runs = list(runs)
    makers: dict[tuple, PlannedRun] = {}
    for run in runs:
        m = run.measurement
        # slip control needs the r_e of a driven wheel
        if m.measurement == "free_rolling" and m.flexplates and run.role == "run":
            makers.setdefault(radius_condition(m), run)
    made: set[str] = set()
    for run in runs:
        if run.key in made:
            continue
        if run.measurement.measurement not in ON_THE_ROAD:
            made.add(run.key)
            yield run
            continue
        maker = makers.setdefault(radius_condition(run.measurement), _radius_run(run))
        if maker.key not in made:
            made.add(maker.key)
            yield replace(maker, role="radius")
        yield replace(run, needs=maker.key)


def _radius_run(run: PlannedRun) -> PlannedRun:
    kept = {k: getattr(run.measurement, k) for k in (*_OF_THE_CONDITION, *_OF_THE_DAY)}
    lines = {k: v for k, v in run.lines.items() if k in kept}
    free = Measurement(measurement="free_rolling", **kept)
    return PlannedRun(f"{RADIUS}{run.key}", free, run.line, lines=lines)
