# SPDX-License-Identifier: Apache-2.0
"""Lateral transient: sigma_y and c_cy of a tire that starts to roll at a slip angle.

On the flat plank the slip angle is set before the road moves, so the step in side slip is the
start of the motion. A lateral run has the same form as a slip-step run, with -Fy in place of Fx,
Fx in place of Fy, tan(alpha) in place of kappa, and the slip angle as level, so that all fits in x
also work in y.

The steering zero comes from runs at +alpha and -alpha: steady Fx, Fy and Mz in one fit. A zero
error d of the steering angle shifts the curves of Fy and Mz, and so does ply steer p. Only d
changes the longitudinal slip: slip control sets the wheel speed for cos(alpha), while the road
moves at cos(alpha + d). This makes dFx = C_Fk(alpha) (cos(alpha) / cos(alpha + d) - 1), odd in
alpha. A conical tire adds a constant force. Parameters of the fit are odd Magic Formula curves
(Pacejka 2012, section 4.3), d, p and the offsets.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from flatplank_analysis.post.gridding import CELL, bin_means
from flatplank_data.errors import FlatplankError
from flatplank_data.table import MeasurementTable
from flatplank_tire.magic_formula.state import curve_angle

from ..starts import mean_over_starts, value_over_starts
from .carcass import CarcassFit, fit_carcass
from .least_squares import solve
from .repeats import with_equal_starts
from .results import Estimate
from .runs import StepRun, by_level

TAIL = 0.3
"""Road before the slip step over which the forces are averaged [m]."""
MIRRORED = 2
"""Number of angles required with both signs."""
SHARE = {"fy": 3e-3, "mz": 3e-4, "fx": 3e-3}
"""Assumed standard error of a steady mean, as a share of Fz (Mz: times 1 m)."""
PLY = math.radians(0.3)
"""Typical size of ply steer [rad]; only Fx separates it from the steering zero."""
NAMES = ("zero", "ply", "d", "b", "e", "fy0", "trail", "bt", "mz0")
"""Parameters of the fit, in the order of LOW, HIGH and START: steering zero and ply steer [rad],
D, B, E and offset of Fy, trail [m] and its B, offset of Mz [m]; forces as shares of Fz."""
LOW = np.array([-0.2, -0.05, 0.05, 0.5, -10.0, -0.3, -0.5, 0.0, -0.05])
HIGH = np.array([0.2, 0.05, 4.0, 90.0, 1.0, 0.3, 0.5, 60.0, 0.05])
START = np.array([0.0, 0.0, 1.0, 12.0, 0.0, 0.0, 0.03, 8.0, 0.0])
PRIOR = {"ply": PLY, "e": 2.0, "fy0": 0.05, "mz0": 2e-3}
"""Parameter -> typical spread about zero; forces as shares of Fz."""
SHAPE_Y, SHAPE_T = 1.4, 1.15
"""Shape factors C of Fy and of the trail, which are held fixed [-]."""


@dataclass(frozen=True)
class SteeringZero:
    """True minus indicated side slip angle of one condition."""

    zero: Estimate
    """Steering zero [deg]."""
    ply: Estimate
    """Ply steer of the tire [deg]."""
    shift: float
    """Sum of both: shift of the curves of Fy and Mz [rad]."""

    def corrected(self, run: StepRun) -> StepRun:
        """A lateral run at its true side slip angle."""
        slip = math.tan(math.radians(run.level) + self.shift)
        return replace(run, kappa=slip, slip=slip * run.distance)


def lack_of_mirrors(levels: Sequence[float]) -> str:
    """Runs that are missing for the steering zero at these angles [deg]; empty if none."""
    known = {round(level, 6) for level in levels if level}
    both = {abs(level) for level in known if -level in known}
    if len(both) >= MIRRORED:
        return ""
    return f"runs at {MIRRORED} angles with both signs, as in alpha_deg: [-5, -1, 1, 5]"


def zero_warning(levels: Sequence[float]) -> str:
    """Warning for every number from these angles [deg]; empty when they determine the zero."""
    lack = lack_of_mirrors(levels)
    return lack and f"a steering zero error is in it: add {lack}"


def steering_zero(runs: Sequence[StepRun]) -> SteeringZero | None:
    """The steering zero from lateral runs of one condition; None without mirrored angles.

    Its standard error contains the errors `SHARE` of the means and, with three or more start
    angles, the scatter between the zeros fitted to each of them.
    """
    if lack_of_mirrors([run.level for run in runs]):
        return None
    whole, errors = _solved(runs)
    starts = sorted({run.start for run in runs})
    parts = [[run for run in runs if run.start == start] for start in starts]
    parts = [part for part in parts if not lack_of_mirrors([r.level for r in part])]
    if len(parts) > 2:
        each = np.array([_solved(part)[0] for part in parts])
        errors = np.hypot(errors, each.std(axis=0, ddof=1) / math.sqrt(len(parts)))
    with_steps = any(math.isfinite(run.slip_stiffness) for run in runs)
    note = (
        ""
        if with_steps
        else "with ply steer: without slip steps at the angles Fx does not part them"
    )
    zero, ply = (
        Estimate(name, math.degrees(value), "deg", math.degrees(error), note=note)
        for name, value, error in zip(("steering_zero", "ply_steer"), whole, errors, strict=False)
    )
    if not with_steps:
        ply = replace(ply, determined=False)
    return SteeringZero(zero, ply, shift=float(whole[0] + whole[1]))


def _solved(runs: Sequence[StepRun]) -> tuple[np.ndarray, np.ndarray]:
    """Parameters in the order of NAMES, and their errors for means with the errors `SHARE`."""
    data = _Steady.of(runs)
    free = np.ones(len(NAMES), bool)
    free[NAMES.index("ply")] = bool(np.isfinite(data.stiffness).any())
    free[NAMES.index("e")] = len(set(np.abs(data.angle).round(4)) - {0.0}) > 2
    start = START.copy()
    start[NAMES.index("trail")] *= float(np.sign(np.sum(data.mz * data.fy) or 1.0)) * -1.0

    def residuals(sets: np.ndarray) -> np.ndarray:
        full = np.tile(start, (len(sets), 1))
        full[:, free] = sets
        return data.residuals(full)

    scale = np.array([0.01, 0.003, 0.3, 4.0, 1.0, 0.02, 0.02, 4.0, 1e-3])
    found = solve(residuals, start[free], LOW[free], HIGH[free], scale[free])
    out, errors = start.copy(), np.zeros(len(NAMES))
    out[free] = found.x
    errors[free] = np.sqrt(np.diag(np.linalg.pinv(found.jacobian.T @ found.jacobian)))
    return out, errors


@dataclass(frozen=True)
class _Steady:
    """Means at the end of the lateral transient, one row per angle; forces as shares of Fz."""

    angle: np.ndarray
    fy: np.ndarray
    """-Fy, which has the sign of the side slip."""
    mz: np.ndarray
    fx: np.ndarray
    stiffness: np.ndarray
    """C_Fk at this angle; NaN without a slip step."""

    @classmethod
    def of(cls, runs: Sequence[StepRun]) -> _Steady:
        last = min(float(run.distance[-1]) for run in runs)
        rows = []
        for level, members in by_level(with_equal_starts(runs)).items():
            starts = [run.start for run in members]
            means = mean_over_starts([_tail(run, last) for run in members], starts)
            slope = value_over_starts([run.slip_stiffness for run in members], starts).value
            load = float(mean_over_starts([run.mean_load for run in members], starts))
            rows.append([math.radians(level), *(means / load), slope / load])
        return cls(*np.array(rows).T)

    def residuals(self, sets: np.ndarray) -> np.ndarray:
        """Normalised errors and priors (sets, n)."""
        p = {name: sets[:, i : i + 1] for i, name in enumerate(NAMES)}
        x = np.tan(self.angle + p["zero"] + p["ply"])
        force = p["d"] * np.sin(curve_angle(SHAPE_Y, p["b"], p["e"], x))
        arm = p["trail"] * np.cos(curve_angle(SHAPE_T, p["bt"], 0.0, x))
        slip = np.cos(self.angle) / np.cos(self.angle + p["zero"]) - 1.0
        rows = [
            (force + p["fy0"] - self.fy) / SHARE["fy"],
            (p["mz0"] - arm * force - self.mz) / SHARE["mz"],
            *self._odd_differences(slip),
        ]
        rows += [p[name] / spread for name, spread in PRIOR.items()]
        return np.hstack([np.broadcast_to(r, (len(sets), r.shape[1])) for r in rows])

    def _odd_differences(self, slip: np.ndarray) -> list[np.ndarray]:
        """Errors of half the difference of Fx at +alpha and -alpha: even parts cancel in it."""
        rows = []
        for i, angle in enumerate(self.angle):
            for j in np.flatnonzero(np.isclose(self.angle, -angle)):
                if angle > 0.0 and np.isfinite(self.stiffness[[i, j]]).all():
                    part = 0.5 * (self.stiffness[i] * slip[:, i] - self.stiffness[j] * slip[:, j])
                    seen = 0.5 * (self.fx[i] - self.fx[j])
                    rows.append(((part - seen) / SHARE["fx"])[:, None])
        return rows


def _tail(run: StepRun, last: float) -> np.ndarray:
    """-Fy, Mz, Fx at the end of the road that all runs share."""
    part = (run.distance > last - TAIL) & (run.distance <= last)
    return np.array([np.mean(values[part]) for values in (run.fx, run.mz, run.fy)])


SMALL_STEP = 0.02
"""Largest slip whose step gives the slip stiffness at a slip angle [-]."""
STARTED = 5e-4
"""Travel after which the road counts as moving [m]."""
RENAMED = {"c_cx": "c_cy", "slip_stiffness": "cornering_stiffness", "sigma_x": "sigma_y"}
"""Quantity of a fit in x -> name of its estimate in y."""


def lateral_run(table: MeasurementTable, spacing: float = CELL) -> StepRun:
    """The part of a run from its start to the slip step, treated as a step in side slip.

    `spacing` of its grid [m]. Raises FlatplankError where the road does not move.
    """
    info = table.info
    alpha = math.radians(info.alpha_deg)
    position = table["plank_position"]
    moving = np.flatnonzero(position > position[0] + STARTED)
    if not len(moving):
        raise FlatplankError("the road does not move", info.file, "leave this run out")
    first = moving[0]
    x = (position[first:] - position[first]) * math.cos(alpha)
    last = len(x)
    if info.kappa != 0.0 and math.isfinite(info.step_position):
        last = int(np.searchsorted(position[first:], info.step_position))
    columns = np.array(
        [-table["fy"], table["fz"], *(np.nan_to_num(table.get(name)) for name in ("mz", "fx"))]
    )
    x, (force, fz, mz, fx) = bin_means(x[:last], columns[:, first : first + last], spacing)
    slip = math.tan(alpha)
    return StepRun(
        name=info.name,
        operating_point=info.condition.operating_point._replace(alpha_deg=math.nan),
        level=info.alpha_deg,
        kappa=slip,
        distance=x,
        fx=force,
        fy=fx,
        mz=mz,
        fz=fz,
        slip=slip * x,
        gamma=math.radians(info.gamma_deg),
        pressure=info.pressure * 1e5,
        start=info.start,
        slip_stiffness=_own_step(table),
    )


def _own_step(table: MeasurementTable) -> float:
    """dFx/dkappa of the run's slip step [N]; NaN without a small step."""
    info, x = table.info, table["plank_position"]
    if not 0.0 < abs(info.kappa) <= SMALL_STEP or not table.has("fx"):
        return math.nan
    before = (x > info.step_position - TAIL) & (x < info.step_position)
    after = x > x[-1] - TAIL
    if x[-1] < info.step_position + 2.0 * TAIL or not before.any():
        return math.nan
    return float(np.mean(table["fx"][after]) - np.mean(table["fx"][before])) / info.kappa


def fit_lateral_carcass(runs: Sequence[StepRun], **options: Any) -> CarcassFit:
    """c_cy [N/m], cornering stiffness [N/rad] and sigma_y [m] from lateral runs of one condition.

    With runs at +alpha and -alpha the steering zero is found first and corrected; without them
    cornering stiffness and c_cy carry a warning. `options` as for `fit_carcass`.
    """
    zero = steering_zero(runs)
    if zero is not None:
        runs = [zero.corrected(run) for run in runs]
    found = fit_carcass(runs, longitudinal=False, **options)
    changes = {name: replace(getattr(found, name), name=other) for name, other in RENAMED.items()}
    bias = {RENAMED[name]: value for name, value in found.model_bias.items()}
    changes["slip_stiffness"] = replace(changes["slip_stiffness"], unit="N/rad")
    warning = zero_warning([run.level for run in runs])
    for name in ("c_cx", "slip_stiffness"):
        changes[name] = changes[name].with_note(warning)
    beside = () if zero is None else (zero.zero, zero.ply)
    return replace(found, model_bias=bias, beside=beside, **changes)
