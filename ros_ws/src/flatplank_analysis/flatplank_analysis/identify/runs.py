# SPDX-License-Identifier: Apache-2.0
"""A slip-step run for the fits: a uniform grid over the distance since the step."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterable
from dataclasses import dataclass, field

import numpy as np
from scipy.ndimage import uniform_filter1d

from flatplank_data.errors import FlatplankError
from flatplank_data.table import MeasurementTable

from ..models.base import RunInputs
from ..post.gridding import bin_means
from .linear import BEFORE, LinearFit, linear_run
from .noise import ARNoise

SMOOTHING = 0.03
"""Window of the moving mean over the measured slip travel [m], applied twice."""
SETTLE = 0.02
"""Travel after the step in which the wheel reaches its new speed [m]; excluded from kappa_act."""


@dataclass(frozen=True, eq=False)
class StepRun:
    """One run on a uniform grid; arrays (n,), `distance` [m] since the step (negative before).

    Runs compare equal only by identity: another campaign may have a run of the same name.
    """

    name: str
    operating_point: Hashable
    """Operating point: runs that share it differ in slip and repeat only."""
    level: float
    """Nominal slip: runs of one condition and level are repeats."""
    kappa: float
    """Actual slip after the step [-]."""
    distance: np.ndarray = field(repr=False)
    fx: np.ndarray = field(repr=False)
    fy: np.ndarray = field(repr=False)
    mz: np.ndarray = field(repr=False)
    fz: np.ndarray = field(repr=False)
    slip: np.ndarray = field(repr=False)
    """Slip travel of the rim since the step: sum of r_e d(angle) - dx [m]."""
    alpha: float = 0.0
    """Slip angle [rad]."""
    gamma: float = 0.0
    """Camber [rad]."""
    pressure: float = 250e3
    """Inflation pressure [Pa]."""
    start: int = 1
    """1, 2, 3: wheel started at 0, 120, 240 deg."""
    slip_stiffness: float = math.nan
    """dFx/dkappa of the slip step of a lateral run [N]; NaN without a small step."""

    @property
    def mean_load(self) -> float:
        """Mean load after the step [N]."""
        return float(np.mean(self.fz[self.distance >= 0.0]))

    @property
    def operating_point_text(self) -> str:
        """The operating point in words."""
        label = getattr(self.operating_point, "label", None)
        return label() if label else str(self.operating_point)

    def after_step(self, values: np.ndarray) -> np.ndarray:
        """The part of a column that follows the step."""
        return values[self.distance >= 0.0]

    def linear(self, noise: ARNoise | None = None) -> LinearFit:
        """Linear transient fit of Fx over kappa."""
        return linear_run(self.distance, self.fx, self.kappa, noise=noise)

    def inputs(self, spacing: float, start_fx: float = 0.0) -> RunInputs:
        """Model inputs from the step on, at the samples of `grid(spacing)`."""
        return self.inputs_at(self.grid(spacing, self.fx)[0], start_fx)

    def inputs_at(self, x: np.ndarray, start_fx: float = 0.0) -> RunInputs:
        """Model inputs at increasing distances x > 0 since the step [m].

        Raises FlatplankError for a run without a pressure.
        """
        if not math.isfinite(self.pressure):
            remedy = "write 'pressure:' [bar] in the run record"
            raise FlatplankError("inflation pressure not stated", self.name, remedy)
        after = self.distance >= 0.0
        own = np.append(0.0, self.distance[after])
        smooth = np.append(0.0, self._steady_slip(own[1:], self.slip[after]))
        # beyond the end of the record the slip continues; such samples have no weight
        slip = np.interp(x, own, smooth) + self.kappa * np.maximum(x - own[-1], 0.0)
        load = np.interp(x, own[1:], self.fz[after])
        travel = np.diff(x, prepend=0.0)

        def hold(value: float) -> np.ndarray:
            return np.full((1, len(x)), value)

        return RunInputs(
            travel=travel[None] * math.cos(self.alpha),
            slip_x=np.diff(slip, prepend=0.0)[None],
            slip_y=np.tan(self.alpha) * math.cos(self.alpha) * travel[None],
            fz=load[None],
            alpha=hold(self.alpha),
            gamma=hold(self.gamma),
            pressure=hold(self.pressure),
            start_fx=np.array([start_fx]),
            start_fy=np.zeros(1),
        )

    def _steady_slip(self, x: np.ndarray, slip: np.ndarray) -> np.ndarray:
        """Slip travel without encoder steps of 0.1 mm: deviations from kappa_act are smoothed."""
        ramp = self.kappa * math.cos(self.alpha) * x
        size = max(int(round(SMOOTHING / (x[1] - x[0]))), 1)
        rest = uniform_filter1d(slip - ramp, size, mode="nearest")
        return ramp + uniform_filter1d(rest, size, mode="nearest")

    def grid(self, spacing: float, columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Means of columns after the step in cells of `spacing` [m]: centres (m,), (..., m)."""
        after = self.distance >= 0.0
        return bin_means(self.distance[after], columns[..., after], spacing)


def step_run(table: MeasurementTable) -> StepRun:
    """A run for the fits, from a measurement table with its run record.

    Raises FlatplankError without a step position, or when the run ends before the step.
    """
    info = table.info
    if not math.isfinite(info.step_position):
        raise FlatplankError("no step_position", info.file, "add it to campaign.yaml [m]")
    alpha, gamma = math.radians(info.alpha_deg), math.radians(info.gamma_deg)
    position = table["plank_position"] - info.step_position
    keep = position >= -3.0 * BEFORE
    if np.count_nonzero(position >= 0.0) < 20:
        raise FlatplankError("the run ends before the step", info.file, "leave this run out")
    rolled = info.effective_rolling_radius * table["wheel_angle"] - position * math.cos(alpha)
    names = ("fx", "fy", "mz", "fz")
    columns = [np.nan_to_num(table.get(n)) if n in ("fy", "mz") else table[n] for n in names]
    data = np.array([*columns, rolled])[:, keep]
    x, means = bin_means(position[keep], data)
    fx, fy, mz, fz, slip = means
    slip = slip - np.interp(0.0, x, slip)
    return StepRun(
        name=info.name,
        operating_point=info.condition.operating_point,
        level=info.kappa,
        kappa=actual_slip(x, slip, alpha),
        distance=x,
        fx=fx,
        fy=fy,
        mz=mz,
        fz=fz,
        slip=slip,
        alpha=alpha,
        gamma=gamma,
        pressure=info.pressure * 1e5,
        start=info.start,
    )


def actual_slip(distance: np.ndarray, slip: np.ndarray, alpha: float = 0.0) -> float:
    """kappa_act [-] (Table 6.3): slope of the slip travel over the travel after the step."""
    part = distance > SETTLE
    return float(np.polyfit(distance[part], slip[part], 1)[0]) / math.cos(alpha)


def by_operating_point(runs: Iterable[StepRun]) -> dict[Hashable, list[StepRun]]:
    """Runs grouped by operating point, in order of appearance."""
    groups: dict[Hashable, list[StepRun]] = {}
    for run in runs:
        groups.setdefault(run.operating_point, []).append(run)
    return groups


def by_level(runs: Iterable[StepRun]) -> dict[float, list[StepRun]]:
    """Runs of one condition grouped by nominal slip, in increasing order."""
    groups: dict[float, list[StepRun]] = {}
    for run in sorted(runs, key=lambda r: r.level):
        groups.setdefault(run.level, []).append(run)
    return groups
