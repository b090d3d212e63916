# SPDX-License-Identifier: Apache-2.0
"""Fits of a whole campaign, one task per condition, and the fit file (YAML), their settings.

```yaml
format: flatplank-fit/1
model: mf                      # linear | nonlinear | lateral | mf
campaigns: [../toyo, ../toyo_repeat]   # merged; may be left to the command line
tire: start.tir                # mf: start values; what is not fitted keeps them
stages: [pure_x, pressure]     # mf: any of the stages, a single one too
free: [PKX2]
fixed: {PKX3: 0.0}             # also friction, tread_stiffness of the nonlinear model
bounds: {PCX1: [1.0, 2.0]}     # also c_cx of the nonlinear model
prior: {PEX4: [0.0, 0.1]}      # value, standard deviation
weights: {fx: 1.0}
joint: true
geometry: {vertical_stiffness: 2.13e5}   # of the nonlinear model (Table 7.2)
```
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, fields
from functools import partial
from pathlib import Path
from typing import Any

from flatplank_data.errors import FlatplankError
from flatplank_data.names import nearest_hint
from flatplank_data.params import from_mapping
from flatplank_data.yaml_text import load_format
from flatplank_tire.tir import TirFile, read_tir

from ..models.base import ContactGeometry
from .carcass import CarcassFit, fit_carcass
from .lateral import fit_lateral_carcass
from .mf.fit import NONLINEAR_FIXED, FitFile, MFFit, fit_magic_formula
from .mf.points import SteadyPoints, merge_with_cx_source, points_from_runs
from .mf.stages import COEFFICIENTS, STAGES
from .repeats import LinearCondition, fit_linear
from .runs import StepRun, by_operating_point

FORMAT = "flatplank-fit/1"


def read_fit_file(path: str | Path) -> FitFile:
    """Read and check a fit file."""
    try:
        text = Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "is no text"
        raise FlatplankError(reason, str(path), "give a fit file") from None
    return parse_fit(text, str(path))


def parse_fit(text: str, where: str = "fit file") -> FitFile:
    """Check keys, names and numbers of a fit file's text."""
    fit = from_mapping(FitFile, load_format(text, where, FORMAT), where)
    _check_names(fit, where)
    return fit


def _check_names(fit: FitFile, where: str) -> None:
    allowed: dict[str, set[str]] = {
        "stages": set(STAGES),
        "free": set(COEFFICIENTS),
        "fixed": set(COEFFICIENTS) | set(NONLINEAR_FIXED),
        "bounds": set(COEFFICIENTS) | {"c_cx"},
        "prior": set(COEFFICIENTS),
        "geometry": {f.name for f in fields(ContactGeometry)},
    }
    for key, names in allowed.items():
        for name in getattr(fit, key):
            if name not in names:
                raise FlatplankError(
                    f"{key}: unknown name '{name}'{nearest_hint(name, names)}", where
                )
    for name, (low, high) in fit.bounds.items():
        if not low < high:
            raise FlatplankError(f"bounds of {name} are {low:g}, {high:g}", where, "low first")
    for name, (_, std) in fit.prior.items():
        if not std > 0.0:
            raise FlatplankError(
                f"prior of {name} has spread {std:g}", where, "give a positive one"
            )


PER_CONDITION: dict[str, Callable[..., LinearCondition | CarcassFit]] = {
    "linear": fit_linear,
    "nonlinear": fit_carcass,
    "lateral": fit_lateral_carcass,
}
Mapper = Callable[[Callable[[Any], Any], Iterable[Any]], Iterable[Any]]
"""`map`, or the same of a process pool or a cluster."""


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


def fit_campaign(
    runs: Sequence[StepRun],
    settings: FitFile,
    *,
    extra: Sequence[SteadyPoints] = (),
    start: TirFile | None = None,
    mapper: Mapper = map,
) -> ConditionFits | MFFit:
    """Fit a model to all runs; `extra`: further points (radius, stiffness, contact).

    `start`: start of a Magic Formula, by default the file named by the settings. `mapper`
    distributes the conditions, for example the `map` of a process pool.

    Raises FlatplankError for an unknown model, and when nothing can be fitted.
    """
    if settings.model not in FITTERS:
        known = ", ".join(FITTERS)
        raise FlatplankError(f"no model {settings.model}", "fit", f"choose one of {known}")
    if not runs:
        raise FlatplankError("no usable run", "fit", "give a campaign with slip-step runs")
    if settings.model != "mf":
        options = {} if settings.model == "linear" else settings.carcass_options()
        done = _per_condition(settings.model, runs, options, mapper)
        fits = tuple(d for d in done if not isinstance(d, str))
        problems = tuple(d for d in done if isinstance(d, str))
        if not fits:
            raise FlatplankError(problems[0], "fit", "see the other conditions too")
        return ConditionFits(settings.model, fits, problems)
    if start is None and not settings.tire:
        raise FlatplankError("no tire to start from", "fit", "give a tire record or a .tir")
    start = start or read_tir(settings.tire)
    parts = list(mapper(points_from_runs, by_operating_point(runs).values()))
    rolling = carcass_fits(runs, settings, mapper) if "stiffness" in settings.stages else []
    points, source = merge_with_cx_source([*parts, *extra], rolling)
    return fit_magic_formula(points, start, settings, source)


def carcass_fits(
    runs: Sequence[StepRun], settings: FitFile, mapper: Mapper = map
) -> list[CarcassFit]:
    """Nonlinear fits of the conditions that have enough slips."""
    done = _per_condition("nonlinear", runs, settings.carcass_options(), mapper)
    return [f for f in done if isinstance(f, CarcassFit)]


def _per_condition(
    model: str, runs: Sequence[StepRun], options: dict[str, Any], mapper: Mapper
) -> list[LinearCondition | CarcassFit | str]:
    return list(mapper(partial(_fit_condition, model, options), by_operating_point(runs).values()))


def _fit_condition(
    model: str, options: dict[str, Any], runs: Sequence[StepRun]
) -> LinearCondition | CarcassFit | str:
    """Fit one condition; an error becomes a line of text, so that the others continue."""
    try:
        return PER_CONDITION[model](runs, **options)
    except FlatplankError as error:
        return str(error)


FITTERS = (*PER_CONDITION, "mf")
"""Models that can be fitted to a campaign."""
