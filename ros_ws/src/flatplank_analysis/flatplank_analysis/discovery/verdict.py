# SPDX-License-Identifier: Apache-2.0
"""The verdict of a search and the report data that belong to it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from flatplank_analysis.discovery import invariants, view, where
from flatplank_analysis.discovery.law import fit_with_law_effects
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.discovery.sources import (
    AT_FLOOR,
    FOUND,
    GROUP,
    LAW,
    NONE,
    PARTLY,
    UNDECIDED,
    Source,
    limited_by_source,
    source_of,
)
from flatplank_analysis.discovery.steps import LARGEST_CLASS, AcceptedEffect, Search, Step
from flatplank_data.errors import FlatplankError
from flatplank_data.wording import quantity, six_digits

LEAST_RUNS = 6
"""least number of runs for a verdict"""


@dataclass(frozen=True)
class Diagnosis:
    """Result of a search; `to_dict` is the interface for programs."""

    verdict: str
    reason: str
    found: tuple[AcceptedEffect, ...]
    floor: float
    rmse_before: float
    rmse_after: float
    held_out_before: float
    held_out_after: float
    unexplained: float
    """systematic part of the residual above the floor"""
    varying: float
    """part of the scatter that known differences between repeats explain"""
    maps: tuple[where.Map, ...]
    events: tuple[where.Event, ...]
    period: float
    """period of the residual over the plank position [m]; NaN without one"""
    coherence: float
    """share of the energy of the residual that is the same in all repeats"""
    next_run: dict[str, Any]
    detectable: dict[str, tuple[float, str]]
    """effect -> smallest size that is found with 80 % power, and its unit"""
    seconds: float
    source: Source
    """source of the floor"""
    limits: invariants.Limits | None = None
    """sizes of consequence in the first channel"""
    search: Search | None = None
    notes: tuple[str, ...] = field(default_factory=tuple)
    conditions: Sequence[dict[str, Any]] = ()
    """error and floor of every condition at the end, see `Floor.rows`"""
    campaign: bool = True
    """True for runs of a campaign folder, which the verbs `repair` and `propose` take"""

    def causes(self) -> list[view.Cause]:
        """What is named, one item per cause."""
        return [view.Cause.of(found) for found in self.found]

    def tasks(self, folder: str = "DIR") -> list[view.Task]:
        """What to do next, the first thing first; `folder`: of the campaign."""
        causes = self.causes()
        return view.tasks(self.verdict, causes, self.next_run, folder if self.campaign else "")

    def drawable(self, campaign: str) -> Search:
        """The search; FlatplankError where the campaign allowed none."""
        if self.search is None:
            raise FlatplankError(self.reason, campaign, "there is nothing to draw")
        return self.search

    def to_dict(self) -> dict[str, Any]:
        """The JSON of `flatplank diagnose --json`."""
        return {
            "verdict": self.verdict,
            "reason": self.reason,
            "effects": [view.cause_dict(f) for f in self.found],
            "runs": self.search.last.state.runs.runs if self.search else 0,
            "floor_rmse": six_digits(self.floor),
            "conditions": list(self.conditions),
            **self.source.to_dict(),
            "rmse_before": six_digits(self.rmse_before),
            "rmse_after": six_digits(self.rmse_after),
            "held_out_before": six_digits(self.held_out_before),
            "held_out_after": six_digits(self.held_out_after),
            "limits": {
                "rest": six_digits(self.limits.rest),
                "stretch": six_digits(self.limits.stretch),
                "bump": six_digits(self.limits.bump),
                "wave": six_digits(self.limits.wave),
                "error_found": six_digits(self.limits.error),
            }
            if self.limits
            else None,
            "unexplained": {
                "rmse": six_digits(self.unexplained),
                "varying": six_digits(self.varying),
                "where": [
                    {
                        "coordinate": m.coordinate,
                        "unit": m.unit,
                        "range": [six_digits(m.place[0]), six_digits(m.place[1])],
                        "share": six_digits(m.place_share),
                    }
                    for m in self.maps[:4]
                ],
                "period": six_digits(self.period) if np.isfinite(self.period) else None,
                "coherence": six_digits(self.coherence),
            },
            "next_run": self.next_run,
            "to_do": [view.task_dict(t) for t in self.tasks()],
            "detectable": {
                k: {"size": six_digits(v), "unit": u} for k, (v, u) in self.detectable.items()
            },
            "notes": list(self.notes),
            "seconds": round(self.seconds, 2),
            **self._posterior(),
        }

    def _posterior(self) -> dict[str, Any]:
        """Probabilities, where the search states them."""
        stated = self.search.stated if self.search else None
        return {"posterior": stated} if stated else {}


def undecidable(runs: RunSet) -> str:
    """Reason why a campaign cannot be decided; empty when it can."""
    if runs.contradicted:
        return "; ".join(runs.contradicted)
    if runs.runs < LEAST_RUNS:
        return f"{runs.runs} runs: at least {LEAST_RUNS} independent runs are needed"
    if source_of(runs).at_most == UNDECIDED:
        return (
            "no repeats, and nothing else that gives a floor (laps, a level visited twice, a way "
            "back, noise at rest, resolution); repeat the conditions"
        )
    if len(runs.groups) < 2:
        return "one condition only: an effect cannot be told from the base"
    return ""


def diagnose(search: Search, next_run: dict[str, Any] | None = None) -> Diagnosis:
    """Judge the end of a search."""
    runs = search.model.runs
    why = undecidable(runs)
    if why:
        search = replace(search, steps=search.steps[:1])
    elif search.last.left:
        search.with_law_effects = fit_with_law_effects(search)
    last, first = search.last, search.steps[0]
    levels = last.state.floors[0]
    residual = last.state.residual[0]
    source = source_of(runs)
    verdict, reason = (UNDECIDED, why) if why else _judged(search, source)
    counts = invariants.limits(last.state)
    maps = where.make_maps(runs, residual, levels.by_condition)
    period, share = _period(runs, residual, verdict)
    pattern = last.state.patterns.strongest(counts.bump, counts.wave)
    if pattern and verdict in (NONE, PARTLY):
        if pattern.words() not in reason:
            reason += f"; clearest is {pattern.words()}"
        maps = where.with_given_ranges(maps, last.state.patterns.ranges(pattern))
        if np.isfinite(pattern.period):
            period, share = pattern.period, 1.0
    return Diagnosis(
        verdict=verdict,
        reason=reason,
        found=tuple(last.found),
        floor=levels.floor,
        rmse_before=runs.rmse(first.state.residual[0]),
        rmse_after=runs.rmse(residual),
        held_out_before=first.held_out,
        held_out_after=last.held_out,
        unexplained=levels.unexplained,
        varying=levels.varying,
        maps=tuple(maps),
        events=tuple(invariants.stretches(last.state)),
        period=period if share > 0.2 else float("nan"),
        coherence=where.coherence(runs, residual),
        next_run=next_run or {},
        detectable=search.detectable,
        seconds=search.seconds,
        source=source,
        limits=counts,
        search=search,
        notes=tuple(_notes(runs, search)),
        conditions=levels.rows(runs),
    )


def _judged(search: Search, source: Source) -> tuple[str, str]:
    """Verdict and its reason, as far as the source of the floor allows one."""
    verdict, reason = limited_by_source(source, *_verdict(search, search.last))
    return verdict, f"{_far_off(search)}{reason}"


def _far_off(search: Search) -> str:
    """What comes first about a base that fits in no condition; empty when it fits."""
    off = invariants.far_off(search.last.state)
    if not off:
        return ""
    return (
        f"the base is far off in every condition, worst {off}, from {search.starts} starts: "
        "check sign and unit of each column; if they are right, "
    )


def _verdict(search: Search, last: Step) -> tuple[str, str]:
    level = last.state.floors[0]
    left = last.left
    with_law_effects = search.with_law_effects
    lawful = with_law_effects is not None and not invariants.residual_of_consequence(
        with_law_effects, bool(last.found)
    )
    named = _named(last)
    by_law = "; a force law of another form explains it"
    if not last.found:
        if not left:
            floor = last.state.runs.amount(level.floor)
            return AT_FLOOR, f"nothing of consequence is left beyond the floor of {floor}"
        if lawful:
            return LAW, left + by_law + ("" if search.notes else ", the machine is in order")
        return NONE, f"{left}; {_unexplained(last)}"
    if _only_law(last) and (lawful or not left):
        return LAW, "the machine is in order; the force law is of another form"
    if left:
        return PARTLY, left + (by_law if lawful else "")
    crowd = max(len(f.alike) for f in named)
    if crowd + 1 > LARGEST_CLASS:
        return GROUP, "no answer: more than four effects look alike; make the next run"
    if crowd:
        return GROUP, "some effects cannot be told apart with these runs"
    return FOUND, "down to the floor"


def _named(last: Step) -> list[AcceptedEffect]:
    return [f for f in last.found if not f.decision.term.effect.generic]


def _only_law(last: Step) -> bool:
    return bool(last.found) and not _named(last)


def _unexplained(last: Step) -> str:
    """Why nothing explains a residual, in words."""
    slight = max((d for d in last.refits if d.slight), key=lambda d: d.drop, default=None)
    if slight is None:
        return "no effect of the library explains it"
    main = slight.term.effect.main_parameter()
    size, matters = quantity(slight.term.size, main.unit), quantity(main.matters, main.unit)
    return (
        f"{slight.term.effect.identifier} of {size} is in the data, but below the size that "
        f"matters ({matters}): not named; no other effect of the library explains it"
    )


def _period(runs: RunSet, residual: np.ndarray, verdict: str) -> tuple[float, float]:
    if verdict not in (NONE, PARTLY) or "plank position" not in runs.coordinates:
        return float("nan"), 0.0
    return where.period_of(runs, residual, "plank position", 0.015)


def _notes(runs: RunSet, search: Search) -> Iterator[str]:
    yield from search.notes
    steps = runs.facts.get("step", np.array([]))
    known = steps[np.isfinite(steps)]
    if known.size and np.ptp(known) < 0.05:
        yield (
            "one step position in all runs: plank position and distance since the step are one "
            "coordinate"
        )
    state = search.last.state
    if unseen := invariants.parameters_without_column(state.whitened.fit):
        yield f"no sample of these runs shows {', '.join(unseen)}: not fitted"
    whitened = invariants.parameters_at_ends(state.fitter, state.whitened.fit)
    if bound := whitened | invariants.parameters_at_ends(state.fitter, state.fit):
        yield "at an end of its range: " + ", ".join(bound.values())


def undecidable_diagnosis(runs: RunSet, seconds: float = 0.0) -> Diagnosis:
    """Diagnosis of a campaign that cannot be decided."""
    nan = float("nan")
    return Diagnosis(
        UNDECIDED, undecidable(runs), (), nan, nan, nan, nan, nan, nan, nan, (), (), nan, nan,
        {}, {}, seconds, source_of(runs),
    )  # fmt: skip
