# SPDX-License-Identifier: Apache-2.0
"""Identification of the Magic Formula in ordered stages, then of all coefficients per output."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from flatplank_data.errors import FlatplankError
from flatplank_data.params import NO_KEY
from flatplank_tire.magic_formula import NOT_OF, Coefficients
from flatplank_tire.tir import TirFile
from flatplank_tire.tir_complete import complete_tir

from ...models.base import ContactGeometry
from ..least_squares import Solution
from ..results import Confusion, Estimate, Fit, relative_error
from .information import REACH, Reach, describe_levels, levels_of
from .points import SteadyPoints
from .problem import OutputProblem, Prior
from .stages import COEFFICIENTS, SMALL_PRESSURE, STAGES, Coefficient, Stage
from .statement import FittedOutput, better_twin, report

JOINT_ORDER = ("rho", "a", "b", "cx", "cy", "re", "fx", "fy", "mz")
"""Outputs in the order of their joint fits; a later fit holds the results of earlier ones."""


NONLINEAR_FIXED = ("friction", "tread_stiffness")
"""Keys of `fixed` that belong to the nonlinear model."""


@dataclass(frozen=True)
class FitFile:
    """Contents of a fit file (see `identify.campaign`): free, fixed, bounds, priors."""

    model: str = "linear"
    campaigns: tuple[str, ...] = ()
    tire: str = ""
    stages: tuple[str, ...] = tuple(STAGES)
    free: tuple[str, ...] = ()
    """Coefficients that are free beside those of the stages, in the first one of their output."""
    fixed: Mapping[str, float] = field(default_factory=dict)
    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    prior: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    """Coefficient -> value and standard deviation."""
    weights: Mapping[str, float] = field(default_factory=dict)
    """Output -> weight relative to the default of the other outputs."""
    joint: bool = True
    """Refit all coefficients of an output together at the end."""
    geometry: Mapping[str, float] = field(default_factory=dict)
    reach: Reach = field(default_factory=lambda: REACH, metadata=NO_KEY)
    """Settings that the bench can make."""

    def carcass_options(self) -> dict[str, Any]:
        """Keyword arguments of `fit_carcass`."""
        options: dict[str, Any] = {k: v for k, v in self.fixed.items() if k in NONLINEAR_FIXED}
        if "c_cx" in self.bounds:
            options["bounds"] = self.bounds["c_cx"]
        if self.geometry:
            options["geometry"] = ContactGeometry(**self.geometry)
        return options


@dataclass(frozen=True)
class MFFit:
    """A fitted tire: the file to use, and one `Fit` per output."""

    tir: TirFile
    fits: Mapping[str, Fit]
    relative_errors: Mapping[str, float]
    """Output -> e_r of (7.28)."""
    skipped: tuple[str, ...] = ()
    """Stages and coefficients that were not fitted, each with the reason."""
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    """Quantity -> lowest and highest value of the points, where they differ."""
    cx_source: str = ""
    """Source of C_x, and so of the relaxation length."""

    @property
    def file(self) -> TirFile:
        """The complete file for other programs; says which coefficients are not determined."""
        open_ones = [e.name for e in self.estimates.values() if not e.determined]
        remarks = dict.fromkeys(open_ones, "not determined by the measured runs")
        return complete_tir(self.tir, self.ranges).remarked(remarks)

    @property
    def estimates(self) -> dict[str, Estimate]:
        """All estimates by name."""
        return {e.name: e for fit in self.fits.values() for e in fit.estimates}

    @property
    def confusions(self) -> tuple[Confusion, ...]:
        """All statements on parameters that cannot be separated."""
        return tuple(c for fit in self.fits.values() for c in fit.confusions)

    def to_json(self) -> dict[str, Any]:
        """Plain values."""
        return {
            "model": "mf",
            "coefficients": {k: float(v) for k, v in self.tir.values.items()},
            "fits": {k: f.to_json() for k, f in self.fits.items()},
            "relative_errors": {k: float(v) for k, v in self.relative_errors.items()},
            "skipped": list(self.skipped),
            "cx_source": self.cx_source,
        }


def fit_magic_formula(
    points: SteadyPoints,
    tir: TirFile,
    settings: FitFile | None = None,
    cx_source: str = "measured points",
) -> MFFit:
    """Fit the stages in order, then all coefficients of each output together.

    The law is that of `tir`; coefficients that are not fitted keep their values there. Raises
    FlatplankError when stages of Fx or Fy were asked for and none could be fitted: the forces
    would be those of `tir`.
    """
    settings = settings or FitFile()
    if not np.isfinite(points.pressure).all():
        remedy = "write 'pressure:' [bar] in the run records"
        raise FlatplankError("inflation pressure not stated", "Magic Formula", remedy)
    base = tir.coefficients.replaced(settings.fixed)
    touched: dict[str, list[str]] = {}
    skipped: list[str] = []
    solved: dict[str, tuple[OutputProblem, Solution]] = {}
    for name in settings.stages:
        if name not in STAGES:
            raise FlatplankError(
                f"no stage {name}", "fit settings", f"stages are {', '.join(STAGES)}"
            )
        stage = STAGES[name]
        chosen = points.rows(stage.select(points, base))
        for output, names in stage.outputs.items():
            of_law = [n for n in names.split() if n not in NOT_OF[tir.law]]
            free = _free(of_law, output, settings, touched)
            data = chosen.with_output(output)
            if len(data):
                free, open_ones = _determined(stage, free, data)
                skipped += [f"{name}: {text}" for text in open_ones]
            reason = _obstacle(stage, output, free, data)
            if reason:
                skipped.append(f"{name}: {reason}")
                continue
            problem, solution = _solve(output, data, free, base, settings)
            base = problem.at(solution.x)
            touched.setdefault(output, []).extend(free)
            solved[output] = (problem, solution)
    _refuse_without_force(points, base, settings, solved)
    if settings.joint:
        base, solved = _jointly(points, touched, base, settings)
    fits: dict[str, Fit] = {}
    earlier: list[FittedOutput] = []
    for output in (k for k in JOINT_ORDER if k in solved):
        fits[output], own = report(output, *solved[output], earlier)
        earlier.append(own)
    fitted = [n for v in touched.values() for n in v]
    changed = {n: float(getattr(base, n)) for n in fitted} | dict(settings.fixed)
    errors = {
        k: relative_error(p.points.measured[k], p.predict(s.x[None])[0])
        for k, (p, s) in solved.items()
    }
    described = cx_source if "cx" in fits else _start_cx(tir)
    return MFFit(tir.replaced(changed), fits, errors, tuple(skipped), points.ranges(), described)


def _start_cx(tir: TirFile) -> str:
    value = tir.coefficients.LONGITUDINAL_STIFFNESS
    if not np.isfinite(value):
        return "not known: no fit and no start file tells it"
    return f"not measured: the start value of {tir.path}"


def _refuse_without_force(
    points: SteadyPoints, base: Coefficients, settings: FitFile, solved: Mapping[str, object]
) -> None:
    """Raise when stages of Fx or Fy were asked for and none could be fitted."""
    forces = {"fx", "fy"}
    wanted = any(forces & set(STAGES[name].outputs) for name in settings.stages)
    if not wanted or forces & set(solved):
        return
    have = [points.with_output(name) for name in forces]
    bars = sorted({round(float(p) * 1e-5, 2) for part in have for p in part.pressure})
    what, remedy = "no steady Fx or Fy to fit", "give slip-step runs"
    if bars and not any(abs(1e5 * bar / base.NOMPRES - 1.0) < SMALL_PRESSURE for bar in bars):
        shown = ", ".join(f"{bar:g}" for bar in bars)
        what += (
            f" at the nominal pressure of {1e-5 * base.NOMPRES:g} bar (runs are at {shown} bar)"
        )
        remedy = "give the record of the tire that was measured (--tire FILE)"
    raise FlatplankError(what, "Magic Formula", remedy)


def _determined(
    stage: Stage, free: Sequence[str], data: SteadyPoints
) -> tuple[list[str], list[str]]:
    """Coefficients that the levels of these points determine, and lines on the others."""
    kept: list[str] = []
    left: dict[str, list[str]] = {}
    for name in free:
        axis, least = stage.levels.get(name, ("", 0))
        if axis and len(levels_of(data, axis)) < least:
            left.setdefault(axis, []).append(name)
        else:
            kept.append(name)
    lines = [
        f"{', '.join(names)} not determined by {describe_levels(data, axis)}; left at the start"
        for axis, names in left.items()
    ]
    return kept, lines


def _obstacle(stage: Stage, output: str, free: Sequence[str], data: SteadyPoints) -> str:
    """Why this stage cannot be fitted to these points; empty when it can."""
    if not free:
        return f"all coefficients of {output} are fixed"
    if len(data) < (1 if stage.levels else 2):
        return f"{'one' if len(data) else 'no'} measurement of {output}"
    for axis in (*stage.needs, *stage.each.get(output, ())):
        if len(levels_of(data, axis)) < 2:
            described = describe_levels(data, axis)
            return f"{', '.join(free)} not determined by {described}; measure a second one"
    return ""


def _free(
    names: Sequence[str], output: str, settings: FitFile, touched: Mapping[str, list[str]]
) -> list[str]:
    """Free coefficients of a stage; extra ones join the first stage that has their output."""
    extra = [] if touched.get(output) else [n for n in settings.free if _output_of(n) == output]
    wanted = dict.fromkeys([*names, *extra])
    done = touched.get(output, [])
    return [n for n in wanted if n not in settings.fixed and n not in done]


def _output_of(name: str) -> str:
    if name not in COEFFICIENTS:
        raise FlatplankError(
            f"{name} cannot be fitted", "fit settings", "see the coefficient table"
        )
    for stage in STAGES.values():
        for output, names in stage.outputs.items():
            if name in names.split():
                return output
    kinds = {"X": "fx", "Y": "fy", "Z": "mz", "Q_RE0": "re", "Q_FZ2": "rho"}
    return kinds.get(name) or kinds[name.rstrip("0123456789")[-1]]


def _solve(
    output: str, data: SteadyPoints, free: Sequence[str], base: Coefficients, settings: FitFile
) -> tuple[OutputProblem, Solution]:
    limits = {n: _limit(n, settings) for n in free}
    priors = {n: Prior(*p) for n, p in settings.prior.items() if n in free}
    weight = settings.weights.get(output, 1.0)
    problem = OutputProblem(
        output, data, tuple(free), base, limits, priors, weight, reach=settings.reach
    )
    solution = problem.solve(broadly=True)
    scatter = _scatter(problem, solution)
    again = replace(problem, base=problem.at(solution.x), scatter=scatter)
    return again, better_twin(again, again.solve())


def _scatter(problem: OutputProblem, solution: Solution) -> float:
    """Residual scatter, relative to the first guess `SCALE`; at least a thousandth of it."""
    n = len(problem.points)
    left = max(n - len(problem.free), 1)
    found = float(np.sqrt(np.sum(solution.residual[:n] ** 2) / left))
    return max(found * problem.weight, 1e-3)


def _limit(name: str, settings: FitFile) -> Coefficient:
    limit = COEFFICIENTS[name]
    if name not in settings.bounds:
        return limit
    low, high = settings.bounds[name]
    start = min(max(limit.start, low), high)
    return limit._replace(start=start, lower=low, upper=high)


def _jointly(
    points: SteadyPoints, touched: Mapping[str, list[str]], base: Coefficients, settings: FitFile
) -> tuple[Coefficients, dict[str, tuple[OutputProblem, Solution]]]:
    solved = {}
    for output in JOINT_ORDER:
        if output not in touched:
            continue
        data = points.with_output(output)
        problem, solution = _solve(output, data, touched[output], base, settings)
        base = problem.at(solution.x)
        solved[output] = (problem, solution)
    return base, solved
