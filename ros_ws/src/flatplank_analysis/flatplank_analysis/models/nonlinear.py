# SPDX-License-Identifier: Apache-2.0
"""Nonlinear transient model: a contact patch with its own relaxation on a spring (7.13-7.24), in
x or in y.

Quasi-static in the patch mass: at 0.03 m/s the inertia of 1 kg is far below the measured forces.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.interpolate import PchipInterpolator

from flatplank_data.errors import FlatplankError

from .base import TOYO, ContactGeometry, RunInputs, column

CELLS = 2000
"""Cells of the uniform table that represents a measured curve."""
LOWEST_SHARE = 0.01
"""Lower limit of the adhering part m of the contact (section 7.2)."""
NEWTON = 3
"""Newton steps per sample: the law is almost linear over one increment."""
HOLDS = 0.5
"""Limit of a falling curve F_ss(kappa'): |dF_ss/dkappa'| / c_cx over the relaxation length of the
patch [-]. Beyond it the spring cannot hold the contact point, and the step leaves it out."""
CLOSE = 1e-9
"""Change of the slip below which the Newton iteration ends [-]."""


@dataclass(frozen=True)
class TableLaw:
    """Look-up table F_ss(kappa) per run (7.14), on fine uniform nodes, extrapolated linearly.

    `values` (runs or 1, nodes) or (sets, runs or 1, nodes) [N] at slips `first` + i `step`.
    """

    first: float
    step: float
    values: np.ndarray

    def force(self, slip: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Force [N] and slope [N] at slip (sets, runs)."""
        place = (slip - self.first) / self.step
        last = self.values.shape[-1] - 2
        cell = np.minimum(np.maximum(place, 0.0), last).astype(np.intp)
        low, high = self._take(cell), self._take(cell + 1)
        rise = high - low
        return low + (place - cell) * rise, rise / self.step

    def stiffness(self) -> np.ndarray:
        """Slope at zero slip over +-0.5 % [N]."""
        values = self.values if self.values.ndim == 3 else self.values[None]
        span = np.full(values.shape[:2], 0.005)
        return (self.force(span)[0] - self.force(-span)[0]) / 0.01

    def _take(self, cell: np.ndarray) -> np.ndarray:
        values = self.values
        if values.ndim == 2:
            return values[np.arange(values.shape[0]), cell]
        sets, runs = values.shape[:2]
        return values[np.arange(sets)[:, None], np.arange(runs), cell]


def table_law(slip: np.ndarray, force: np.ndarray) -> TableLaw:
    """Table through measured steady forces (figure 7.7).

    Between the points a monotone cubic (no kinks that disturb a search, no overshoot).
    `slip` (k,) increasing, `force` (k,) or (sets, k) [N].
    """
    slip = np.asarray(slip, float)
    force = np.atleast_2d(np.asarray(force, float))
    if len(slip) < 2 or np.any(np.diff(slip) <= 0.0):
        raise FlatplankError(
            "steady-state curve needs two or more increasing slips", "", "measure more slips"
        )
    reach = slip[-1] - slip[0]
    first, step = slip[0], reach / CELLS
    even = first + step * np.arange(CELLS + 1)
    values = PchipInterpolator(slip, force, axis=1)(even)
    return TableLaw(float(first), float(step), values[:, None, :] if len(values) > 1 else values)


@dataclass(frozen=True)
class NonlinearX:
    """Fx from F_ss(kappa'): sigma_c dkappa' + kappa' |dx| = ds - du, c_cx u = F_ss (quasi-static).

    `law` gives the table for parameters (sets, 1) of c_cx [N/m]; `friction` mu [-];
    `tread_stiffness` c_px [N/m2]; None: it follows from the slope of the table by the brush model,
    2 c_px a^2 = C_Fk, so that errors of the two cannot compensate each other. `longitudinal`: slip
    also changes the distance that a tread element travels, by the factor 1 + kappa'.
    """

    law: Callable[[np.ndarray], TableLaw]
    geometry: ContactGeometry = TOYO
    friction: float = 0.993
    tread_stiffness: float | None = None
    longitudinal: bool = True

    def simulate(self, params: np.ndarray, inputs: RunInputs) -> np.ndarray:
        """Fx [N] (sets, runs, samples)."""
        return self._force(params, inputs, inputs.slip_x, inputs.start_fx)

    def _force(
        self, params: np.ndarray, inputs: RunInputs, moved: np.ndarray, start: np.ndarray
    ) -> np.ndarray:
        law, shape = self.law(params), (len(params), inputs.shape[0])
        compliance = np.broadcast_to(1.0 / column(params, 0), shape)
        a = self.geometry.half_length(inputs.fz, inputs.pressure)
        limit = 3.0 * self.friction * np.maximum(inputs.fz, 1.0)
        if self.tread_stiffness is None:
            theta = np.abs(law.stiffness())[..., None] / limit
        else:
            theta = (2.0 * self.tread_stiffness * a**2 / limit)[None]
        slip = start_slip(law, np.broadcast_to(start, shape))
        rows = (slip, compliance, inputs.travel, moved, a, theta)
        table = law.values if law.values.ndim == 3 else law.values[None]
        return march(
            *(np.ascontiguousarray(row) for row in rows),
            law.first,
            law.step,
            np.ascontiguousarray(table),
            self.longitudinal,
        )


@dataclass(frozen=True)
class NonlinearY(NonlinearX):
    """Fy over the lateral slip of the patch; `law` gives -Fy over tan(alpha'), which rises, for
    parameters (sets, 1) of c_cy [N/m]."""

    longitudinal: bool = False

    def simulate(self, params: np.ndarray, inputs: RunInputs) -> np.ndarray:
        """Fy [N] (sets, runs, samples)."""
        return -self._force(params, inputs, inputs.slip_y, -inputs.start_fy)


def start_slip(law: TableLaw, force: np.ndarray) -> np.ndarray:
    """Contact-patch slip at which the law gives `force` (sets, runs): the start (7.24)."""
    slip = np.zeros(force.shape)
    steepest = np.abs(law.stiffness()) + 1.0
    for _ in range(30):
        value, slope = law.force(slip)
        slope = np.sign(slope + 1e-300) * np.maximum(np.abs(slope), 0.02 * steepest)
        change = np.clip((value - force) / slope, -0.02, 0.02)
        slip = np.clip(slip - change, -0.2, 0.2)
        if np.max(np.abs(change)) < 1e-12:
            break
    return slip


@njit(cache=True)
def march(
    slip: np.ndarray,
    compliance: np.ndarray,
    travel: np.ndarray,
    moved: np.ndarray,
    half: np.ndarray,
    theta: np.ndarray,
    first: float,
    step: float,
    table: np.ndarray,
    longitudinal: bool,
) -> np.ndarray:
    """Force (sets, runs, samples) [N] by an implicit step over every increment.

    The weights of both ends of the increment are those of the exponential solution: of second
    order where the force relaxes slowly, without oscillation where it follows at once. sigma_c of
    (7.17), (7.18) shrinks with the adhering share of the contact. Where the table falls so fast
    that no spring holds the contact point (`HOLDS`), the step leaves the spring out.

    `slip` before sample 0, `compliance` (sets, runs); `travel`, `moved` (the slip increments),
    `half` contact length a (runs, samples); `theta` of (7.19) (1 or sets, 1 or runs, samples);
    `table` (1 or sets, 1 or runs, nodes).
    """
    sets, runs = slip.shape
    samples, last = travel.shape[1], table.shape[2] - 2
    out = np.empty((sets, runs, samples))
    for index in range(sets):
        for run in range(runs):
            forces = table[min(index, table.shape[0] - 1), min(run, table.shape[1] - 1)]
            limits = theta[min(index, theta.shape[0] - 1), min(run, theta.shape[1] - 1)]
            k, soft = slip[index, run], compliance[index, run]
            place = (k - first) / step
            cell = int(min(max(place, 0.0), last))
            slope = (forces[cell + 1] - forces[cell]) / step
            force = forces[cell] + (place - cell) * (forces[cell + 1] - forces[cell])
            for i in range(samples):
                way, a, limit = travel[run, i], half[run, i], limits[i]
                before, held = k, soft * force
                base = max(1.0 + k, 0.1) if longitudinal else 1.0
                sigma = max(1.0 - limit * abs(k) / base, LOWEST_SHARE) * a / base
                ratio = max(way / (sigma + soft * max(slope, 0.0)), 1e-4)
                late = (-1.0 / np.expm1(-ratio) - 1.0 / ratio) * way
                goal = moved[run, i] - (way - late) * k
                for _ in range(NEWTON):
                    middle = 0.5 * (k + before)
                    base = max(1.0 + middle, 0.1) if longitudinal else 1.0
                    sigma = max(1.0 - limit * abs(middle) / base, LOWEST_SHARE) * a / base
                    shrink = 0.0
                    if sigma * base > LOWEST_SHARE * a:
                        shrink = 0.5 * limit * a * abs(k - before)
                    drawn = soft * force - held if soft * slope > -HOLDS * sigma else 0.0
                    error = goal - sigma * (k - before) - late * k - drawn
                    rate = sigma - min(shrink, 0.5 * sigma) + late + soft * max(slope, 0.0)
                    change = error / rate
                    k += change
                    place = (k - first) / step
                    cell = int(min(max(place, 0.0), last))
                    slope = (forces[cell + 1] - forces[cell]) / step
                    force = forces[cell] + (place - cell) * (forces[cell + 1] - forces[cell])
                    if abs(change) < CLOSE:
                        break
                out[index, run, i] = force
    return out
