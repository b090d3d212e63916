# SPDX-License-Identifier: Apache-2.0
"""Fits of a whole campaign, one task per condition, so that any scheduler can spread them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from flatplank_data.errors import FlatplankError

from ..models.tir import TirFile, read_tir
from .carcass import fit_carcass
from .carcass_report import CarcassFit
from .fit_file import FitFile
from .lateral import fit_lateral_carcass
from .mf.fit import MFFit, fit_magic_formula
from .mf.points import SteadyPoints, gathered, points_from_runs
from .repeats import LinearCondition, fit_linear
from .runs import StepRun, by_condition

PER_CONDITION: dict[str, Callable[..., LinearCondition | CarcassFit]] = {
    "linear": fit_linear,
    "nonlinear": fit_carcass,
    "lateral": fit_lateral_carcass,
}
Mapper = Callable[[Callable[[Any], Any], Iterable[Any]], Iterable[Any]]
"""`map` or anything like it (`executor.map`, a cluster's)."""


class Result(Protocol):
    """What every fit of a campaign hands back."""

    def to_json(self) -> dict[str, Any]:
        """Plain values."""
        ...


@dataclass(frozen=True)
class ConditionFits:
    """Fits per condition, and the conditions that could not be fitted, with the reason."""

    model: str
    fits: tuple[LinearCondition | CarcassFit, ...]
    problems: tuple[str, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """Plain values."""
        return {
            "model": self.model,
            "conditions": [fit.to_json() for fit in self.fits],
            "problems": list(self.problems),
        }


@dataclass(frozen=True)
class _Task:
    """One condition; picklable, so that it can go to another process."""

    model: str
    runs: tuple[StepRun, ...]
    options: dict[str, Any]


def fit_campaign(
    runs: Sequence[StepRun],
    settings: FitFile,
    *,
    extra: Sequence[SteadyPoints] = (),
    start: TirFile | None = None,
    mapper: Mapper = map,
) -> Result:
    """Fit a model to all runs; `extra` are points beyond them (radius, stiffness, contact).

    `start` is what a Magic Formula starts from, else the file that the settings name. `mapper`
    spreads the conditions, for example the `map` of a process pool.
    """
    if settings.model not in FITTERS:
        known = ", ".join(FITTERS)
        raise FlatplankError(f"no model {settings.model}", "fit", f"choose one of {known}")
    if not runs:
        raise FlatplankError("no usable run", "fit", "give a campaign with slip-step runs")
    if settings.model != "mf":
        return _per_condition(runs, settings, mapper)
    if start is None and not settings.tire:
        raise FlatplankError("no tire to start from", "fit", "give a tire record or a .tir")
    return _magic_formula(runs, settings, extra, start or read_tir(settings.tire), mapper)


def _per_condition(runs: Sequence[StepRun], settings: FitFile, mapper: Mapper) -> ConditionFits:
    options = {} if settings.model == "linear" else settings.carcass_options()
    tasks = [
        _Task(settings.model, tuple(members), options) for members in by_condition(runs).values()
    ]
    done = list(mapper(_run_task, tasks))
    fits = tuple(d for d in done if not isinstance(d, str))
    problems = tuple(d for d in done if isinstance(d, str))
    if not fits:
        raise FlatplankError(problems[0], "fit", "see the other conditions too")
    return ConditionFits(settings.model, fits, problems)


def _run_task(task: _Task) -> LinearCondition | CarcassFit | str:
    """Fit one condition; a bad one is a line of text, so that the others go on."""
    try:
        return PER_CONDITION[task.model](task.runs, **task.options)
    except FlatplankError as error:
        return str(error)


def _magic_formula(
    runs: Sequence[StepRun],
    settings: FitFile,
    extra: Sequence[SteadyPoints],
    start: TirFile,
    mapper: Mapper,
) -> MFFit:
    parts = list(mapper(points_from_runs, by_condition(runs).values()))
    wanted = "stiffness" in settings.stages
    fits = carcass_fits(runs, settings, mapper) if wanted else []
    points, source = gathered([*parts, *extra], fits)
    return fit_magic_formula(points, start, settings.mf_settings(), source)


def carcass_fits(
    runs: Sequence[StepRun], settings: FitFile, mapper: Mapper = map
) -> list[CarcassFit]:
    """Nonlinear fits of the conditions that have enough slips."""
    options = settings.carcass_options()
    tasks = [_Task("nonlinear", tuple(m), options) for m in by_condition(runs).values()]
    return [f for f in mapper(_run_task, tasks) if isinstance(f, CarcassFit)]


FITTERS = (*PER_CONDITION, "mf")
"""Models that a campaign can be fitted with."""
