# SPDX-License-Identifier: Apache-2.0
"""One slip level of one operating point: mean of its runs (section 6.2) and its linear model."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from flatplank_analysis.identify.linear import LinearFit, linear_run
from flatplank_analysis.post.filtering import low_pass
from flatplank_analysis.post.gridding import SPACING, Gridded, mean_of_starts, on_grid, repeat_std
from flatplank_analysis.post.slip import StepFacts, step_facts
from flatplank_analysis.report.results import ConditionResult
from flatplank_data.condition import Condition
from flatplank_data.errors import FlatplankError
from flatplank_data.lost import lost_samples
from flatplank_data.table import MeasurementTable

SHOWN = ("fx", "fy", "fz", "plank_velocity")
THIN = 20
"""every 20th point of the 0.1 mm grid is kept after the filter: 2 mm"""
TAIL = 0.5
"""road over which a steady lateral force is averaged [m]"""


def condition_result(condition: Condition, tables: Sequence[MeasurementTable]) -> ConditionResult:
    """Mean of the runs, low-passed (section 6.2), and its linear model (7.11, 7.12)."""
    step = tables[0].info.step_position
    if not math.isfinite(step):
        file = tables[0].info.file
        raise FlatplankError("no step_position", file, "add it to campaign.yaml [m]")
    gridded = [on_grid(t, SHOWN) for t in tables]
    starts = [t.info.start for t in tables]
    mean = mean_of_starts(gridded, starts).map(low_pass)
    repeats = _repeats(gridded, starts)
    facts = mean_facts([step_facts(t) for t in tables], starts)
    kappa = facts.kappa_actual if math.isfinite(facts.kappa_actual) else condition.kappa
    good = np.isfinite(mean["fx"])
    thin = slice(None, None, THIN)
    return ConditionResult(
        condition,
        [t.info.name for t in tables],
        facts,
        step,
        mean.position[thin],
        {name: values[thin] for name, values in mean.columns.items()},
        _scatter(repeats),
        len(repeats) < len(gridded) or len(set(starts)) == 1,
        linear_run(mean.position[good] - step, mean["fx"][good], kappa),
        {t.info.name: _run_fit(t, step) for t in tables},
        _tail(mean),
        sum(lost_samples(t).lost for t in tables),
    )


def _run_fit(table: MeasurementTable, step: float) -> LinearFit:
    facts = step_facts(table)
    kappa = facts.kappa_actual if math.isfinite(facts.kappa_actual) else table.info.kappa
    return linear_run(table["plank_position"] - step, table["fx"], kappa)


def _repeats(runs: Sequence[Gridded], starts: Sequence[int]) -> list[Gridded]:
    """Runs whose scatter is shown: those of the start angle that was repeated, else all."""
    counts = {s: starts.count(s) for s in starts}
    most = max(counts, key=lambda s: counts[s])
    uneven = counts[most] > 2 and len(set(counts.values())) > 1
    return [r for r, s in zip(runs, starts, strict=True) if s == most or not uneven]


def _scatter(gridded: Sequence[Gridded]) -> np.ndarray | None:
    if len(gridded) < 2:
        return None
    smooth = [g.map(low_pass, ["fx"]) for g in gridded]
    return repeat_std(smooth, "fx")[::THIN]


def _tail(mean: Gridded) -> float:
    if "fy" not in mean.columns:
        return math.nan
    last = mean["fy"][np.isfinite(mean["fy"])][-round(TAIL / SPACING) :]
    return float(last.mean()) if last.size else math.nan


def mean_facts(facts: Sequence[StepFacts], starts: Sequence[int]) -> StepFacts:
    """Mean of the start angles, each the mean of its runs, as the forces are averaged."""
    groups = [
        [f for f, s in zip(facts, starts, strict=True) if s == one]
        for one in dict.fromkeys(starts)
    ]

    def mean(values: Sequence[float]) -> float:
        known = [v for v in values if math.isfinite(v)]
        return sum(known) / len(known) if known else math.nan

    names = [f.name for f in dataclasses.fields(StepFacts)]
    return StepFacts(
        **{n: mean([mean([getattr(f, n) for f in group]) for group in groups]) for n in names}
    )
