# SPDX-License-Identifier: Apache-2.0
"""A tire file from sweeps: the Magic Formula, fitted to the mean curves of the conditions.

A point of the fit is one bin of a condition: the mean of force and channels while the slip rises,
and of those while it falls, with equal weights, so that relaxation cancels. Bins count as
independent of each other.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from flatplank_analysis.identify.mf.fit import FitFile, MFFit, fit_magic_formula
from flatplank_analysis.identify.mf.information import Reach, reach_of
from flatplank_analysis.identify.mf.points import AXES, SteadyPoints, steady_points
from flatplank_analysis.identify.mf.stages import general_start
from flatplank_analysis.identify.results import rmse, to_plain
from flatplank_analysis.models.base import SPEED
from flatplank_analysis.models.tire_record import TireRecord, start_tir
from flatplank_analysis.slip_sweeps.conditions import BY_NAME, FORCE, SweepCondition
from flatplank_analysis.slip_sweeps.curves import Curve, bin_means
from flatplank_analysis.slip_sweeps.further import further
from flatplank_analysis.slip_sweeps.origin import marked
from flatplank_analysis.slip_sweeps.study import Study
from flatplank_data.errors import FlatplankError
from flatplank_tire.magic_formula import steady_forces
from flatplank_tire.tir import VERSIONS, TirFile, write_tir

STAGES = ("pure_x", "pure_y", "aligning", "combined", "pressure", "camber")
"""stages of which sweeps have the measurements; radius and stiffness are those of the start"""
RADIUS = "not measured by sweeps: give --radius"
FORCES = ("fx", "fy", "mz")
"""as `steady_forces` gives them"""
PRESSURE = "not in the sweeps: a placeholder"
LEAST_LOADS = 3
"""loads from which a fit to all but one of them still knows how the tire changes with load"""
LOAD, SIDE_SLIP = BY_NAME["fz"], BY_NAME["alpha"]
Progress = Callable[[int, int, str], None]


@dataclass(frozen=True)
class HeldOut:
    """Error for a load that the fit has not seen."""

    force: str
    """fx, fy or mz"""
    load: float
    """[N]"""
    error: float
    """root mean square of the points [N], of Mz [Nm]"""
    r_squared: float
    """share of the variance of the points that the fit to the other loads explains [-]"""


@dataclass(frozen=True)
class SweepFit:
    """A tire fitted to sweeps."""

    fit: MFFit
    points: int
    held_out: tuple[HeldOut, ...]
    """one per force and load; empty with fewer than three loads"""
    remarks: Mapping[str, str]
    """coefficient -> why its value is not from these sweeps"""
    paths: tuple[str, ...]
    """files of the sweeps"""

    @property
    def file(self) -> TirFile:
        """The complete file; what these sweeps do not determine is marked in its comments."""
        return marked(self.fit.file.remarked(self.remarks), self.paths)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the tire file; return its path."""
        write_tir(self.file, Path(path))
        return Path(path)

    def to_json(self) -> dict[str, Any]:
        """Plain values, SI."""
        return self.fit.to_json() | {
            "points": self.points,
            "held_out": to_plain(self.held_out),
            "remarks": self.remarks,
        }


def fit_sweeps(
    studies: Sequence[Study],
    start: TirFile | None = None,
    radius: float | None = None,
    progress: Progress = lambda _done, _all, _what: None,
    version: str | None = None,
) -> SweepFit:
    """Fit a tire file to sweeps, in stages, then all coefficients of a force together.

    start: values of what is not determined; None: general start values, of no tire. radius: of
    the free tire [m]. version: of the equations, 5.2, 6.1 or 6.2; None: that of the start, or 6.1.

    Raises:
        FlatplankError: neither Fx nor Fy is in the sweeps, there is no such version, or the start
            is of another one.
    """
    if version is not None and version not in VERSIONS:
        raise FlatplankError(f"no version {version}", "--mf", f"known: {', '.join(VERSIONS)}")
    points = points_of(studies)
    remarks: dict[str, str] = {}
    if start is None:
        remarks = {} if radius else {"UNLOADED_RADIUS": RADIUS}
        remarks |= {} if np.isfinite(points.pressure).any() else {"NOMPRES": PRESSURE}
        start = _start(studies, points, radius).of_version(version or "6.1")
    elif version and start.of_version(version).law != start.law:
        what = f"is of Magic Formula {start.law}, the fit of {version}"
        raise FlatplankError(what, start.path or "start file", "leave --mf or --start out")
    elif radius:
        start = start.replaced({"UNLOADED_RADIUS": radius})
    points = _with_pressure(points, start)
    reach = reach_of(points)
    parts = _without_each_load(points)
    progress(0, len(parts) + 1, "all loads")
    fit = _fitted(points, start, reach)
    held_out: list[HeldOut] = []
    for k, (others, left) in enumerate(parts, start=1):
        progress(k, len(parts) + 1, f"without {np.median(left.fz):.0f} N")
        held_out += _held_out(others, left, start, reach)
    progress(len(parts) + 1, len(parts) + 1, "done")
    paths = tuple(one.path for one in studies)
    return SweepFit(fit, len(points), tuple(held_out), remarks, paths)


def _fitted(points: SteadyPoints, start: TirFile, reach: Reach) -> MFFit:
    """The fit to points; reach: settings of the next sweep."""
    free = further(points, start.law)
    settings = FitFile(model="mf", stages=STAGES, free=free, reach=reach)
    return fit_magic_formula(points, start, settings)


def points_of(studies: Sequence[Study]) -> SteadyPoints:
    """Points of all conditions of all files; a pressure that a file does not have is NaN."""
    each = [
        _points_of(study.columns, condition, curve)
        for study in studies
        for condition, curve in zip(study.conditions, study.curves, strict=True)
    ]
    columns = {name: np.concatenate([part[name] for part in each]) for name in each[0]}
    axes = {name: columns.pop(name) for name in AXES}
    return steady_points(columns, **axes)


def _points_of(
    columns: Mapping[str, np.ndarray], condition: SweepCondition, curve: Curve
) -> dict[str, np.ndarray]:
    """Channels and forces in the bins of a condition in which the force is known."""
    rows = condition.samples

    def mean(name: str, missing: float) -> np.ndarray:
        if name not in columns:
            return np.full(len(curve.force), missing)
        values = columns[name][rows]
        up, down = (bin_means(curve.bins, values, way) for way in (curve.rising, ~curve.rising))
        both = 0.5 * (up + down)
        return np.where(np.isfinite(both), both, bin_means(curve.bins, values))

    out = {name: mean(name, np.nan if name == "pressure" else 0.0) for name in AXES}
    wanted = ("fy", "mz") if condition.swept == "alpha" else ("fx",)
    if abs(condition.held.get("alpha", 0.0)) > SIDE_SLIP.apart:
        wanted = ("fx", "fy")  # of combined slip
    forces = {name: mean(name, np.nan) for name in ("fx", "fy", "mz")}
    blank = np.full(len(curve.force), np.nan)
    out |= {name: forces[name] if name in wanted else blank for name in forces}
    known = np.isfinite(out[FORCE[condition.swept]])
    return {name: values[known] for name, values in out.items()}


def _start(studies: Sequence[Study], points: SteadyPoints, radius: float | None) -> TirFile:
    """Start values of no tire, with load and pressure in the middle of the measured ones."""
    loads = sorted(c.held["fz"] for s in studies for c in s.conditions if "fz" in c.held)
    nominal = loads[len(loads) // 2] if loads else float(np.median(points.fz))
    pressures = sorted(c.held["pressure"] for s in studies for c in s.conditions
                       if "pressure" in c.held)  # fmt: skip
    bar = 1e-5 * pressures[len(pressures) // 2] if pressures else 2.0
    record = TireRecord("sweeps", radius or 0.3, round(nominal), bar, origin=studies[0].path)
    speeds = [np.abs(s.columns["speed"]) for s in studies if "speed" in s.columns]
    speed = float(np.median(np.concatenate(speeds))) if speeds else SPEED
    return start_tir(record, general_start()).replaced({"LONGVL": max(speed, 0.1)})


def _with_pressure(points: SteadyPoints, start: TirFile) -> SteadyPoints:
    """The points, at the nominal pressure where a file has none."""
    pressure = np.where(np.isfinite(points.pressure), points.pressure, start.coefficients.NOMPRES)
    return replace(points, pressure=pressure)


def _without_each_load(points: SteadyPoints) -> list[tuple[SteadyPoints, SteadyPoints]]:
    """Points of all loads but one, and of that one; none with fewer than three loads."""
    number = _load_levels(points)
    count = number.max() + 1
    if count < LEAST_LOADS:
        return []
    return [(points.rows(number != k), points.rows(number == k)) for k in range(count)]


def _held_out(
    others: SteadyPoints, left: SteadyPoints, start: TirFile, reach: Reach
) -> Iterator[HeldOut]:
    """Points predicted by a fit to others; nothing where the others have no force to fit."""
    try:
        fit = _fitted(others, start, reach)
    except FlatplankError:
        return
    modelled = steady_forces(
        fit.tir.coefficients, left.fz, kappa=left.kappa, alpha=left.alpha, gamma=left.gamma,
        pressure=left.pressure, vx=SPEED,
    )  # fmt: skip
    for force in (f for f in FORCES if f in fit.fits):
        measured = left.measured[force]
        known = np.isfinite(measured)
        if known.any():
            error = rmse(measured, modelled[FORCES.index(force)], known)
            spread = float(np.var(measured[known]))
            explained = 1.0 - error**2 / spread if spread > 0.0 else np.nan
            yield HeldOut(force, float(np.median(left.fz)), error, explained)


def _load_levels(points: SteadyPoints) -> np.ndarray:
    """Number of the load level of each point (n,)."""
    order = np.argsort(points.fz, kind="stable")
    apart = LOAD.distance(points.fz)
    number = np.empty(len(points), int)
    number[order] = np.concatenate([[0], np.cumsum(np.diff(points.fz[order]) > apart)])
    return number
