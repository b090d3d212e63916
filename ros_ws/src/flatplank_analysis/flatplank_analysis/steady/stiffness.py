# SPDX-License-Identifier: Apache-2.0
"""Stiffnesses (vertical: Appendix G.2), contact length of footprints (G.1), and friction."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flatplank_data.errors import FlatplankError
from flatplank_data.table import MeasurementTable

WINDOW = (0.285, 0.305)
"""range of loaded radius for the fit, outside the play of the supports [m]"""


@dataclass(frozen=True)
class VerticalStiffness:
    """C_z of one run [N/m]."""

    loading: float
    unloading: float
    window: tuple[float, float]

    @property
    def mean(self) -> float:
        """Mean of loading and unloading, as in the thesis."""
        both = [v for v in (self.loading, self.unloading) if math.isfinite(v)]
        return float(np.mean(both)) if both else math.nan


def vertical_stiffness(
    table: MeasurementTable, window: tuple[float, float] | None = None
) -> VerticalStiffness:
    """Slope of Fz over loaded radius while loading and while unloading.

    Without a window: that of the thesis, as far as the run goes, where it goes through half of
    it; otherwise the middle of the run.
    """
    radius, force = table["loaded_radius"], table["fz"]
    window = window or _window(radius)
    turn = int(np.argmin(radius))
    inside = (radius >= window[0]) & (radius <= window[1])
    down, up = inside.copy(), inside.copy()
    down[turn:] = False
    up[:turn] = False
    values = [_slope(radius[part], force[part]) for part in (down, up)]
    if not np.isfinite(values).any():
        raise FlatplankError(
            f"no load change between {window[0]:g} and {window[1]:g} m",
            table.info.file,
            "give a window of loaded radius that the run goes through",
        )
    return VerticalStiffness(values[0], values[1], window)


def _window(radius: np.ndarray) -> tuple[float, float]:
    low, high = float(radius.min()), float(radius.max())
    if low <= 0.5 * sum(WINDOW) and high >= WINDOW[1]:
        return max(low, WINDOW[0]), WINDOW[1]
    return low + 0.1 * (high - low), low + 0.7 * (high - low)


def _slope(radius: np.ndarray, force: np.ndarray) -> float:
    if radius.size < 5 or np.ptp(radius) < 1e-4:
        return math.nan
    return float(-np.polyfit(radius, force, 1)[0])


def static_longitudinal_stiffness(
    table: MeasurementTable, share: tuple[float, float] = (0.05, 0.25), max_turn: float = 1.5e-3
) -> float:
    """C_x of the standing tire [N/m]: the plank moves while the drive holds the wheel.

    Slope of Fx over the travel of the road relative to the rim, while the wheel has turned by less
    than `max_turn` [rad] (wind-up and gap of its gear) and |Fx| is within `share` of Fz: below,
    the road still moves through its play; above, the tread begins to slide. NaN without such a
    part.
    """
    x, angle, fx = table["plank_position"], table["wheel_angle"], table["fx"]
    load = table.info.fz if math.isfinite(table.info.fz) else float(np.mean(table["fz"]))
    radius = table.info.effective_rolling_radius
    begin = int(np.argmax(x > x[0] + 5e-5))
    turned = angle - angle[max(begin - 1, 0)]
    free = np.abs(turned) > max_turn
    end = begin + int(np.argmax(free[begin:])) if free[begin:].any() else x.size
    travel = (x - (radius if math.isfinite(radius) else 0.3) * turned)[begin:end]
    force = np.abs(fx[begin:end] - fx[max(begin - 1, 0)])
    good = (force >= share[0] * load) & (force <= share[1] * load)
    if good.sum() < 3 or np.ptp(travel[good]) < 2e-4:
        return math.nan
    return float(abs(np.polyfit(travel[good], force[good], 1)[0]))


def standing_lateral_stiffness(
    table: MeasurementTable, share: tuple[float, float] = (0.05, 0.2)
) -> float:
    """C_y of the standing tire [N/m]: the road moves slowly under the steered, locked wheel.

    Slope of Fy over the lateral travel while the whole force is within `share` of Fz.
    NaN without such a part.
    """
    side = math.sin(math.radians(table.info.alpha_deg))
    load = float(np.mean(table["fz"]))
    size = np.hypot(table["fx"] - table["fx"][0], table["fy"] - table["fy"][0])
    beyond = np.flatnonzero(size > share[1] * load)
    last = int(beyond[0]) if beyond.size else size.size
    first = int(np.argmax(size[:last] > share[0] * load)) if last else 0
    travel, force = side * table["plank_position"][first:last], table["fy"][first:last]
    if travel.size < 5 or np.ptp(travel) < 1e-4:
        return math.nan
    return float(abs(np.polyfit(travel, force, 1)[0]))


def locked_friction(table: MeasurementTable) -> float:
    """mu of the sliding locked wheel [-]: mean over the second half of the travel."""
    x = table["plank_position"]
    force = np.hypot(table["fx"], table["fy"]) if table.has("fy") else np.abs(table["fx"])
    sliding = x > 0.5 * (x[0] + x[-1])
    return float(np.mean(force[sliding] / table["fz"][sliding])) if sliding.any() else math.nan


@dataclass(frozen=True)
class ContactLength:
    """a = r_0 (q_ra2 F_z/(C_z r_0) + q_ra1 sqrt(F_z/(C_z r_0))) (7.20)."""

    q_ra1: float
    q_ra2: float
    radius: float
    """r_0 [m]"""
    rmse: float
    """[m]"""
    both: bool = True
    """False: one load cannot separate q_ra1 and q_ra2, and q_ra2 is held at 0"""


def fit_contact_length(
    fz: np.ndarray, half_length: np.ndarray, stiffness: np.ndarray, radius: float
) -> ContactLength:
    """Linear least squares for q_ra1, q_ra2; arrays of shape (footprints,), SI.

    With one footprint only, q_ra2 is 0: a single load cannot separate the two.
    """
    deflection = np.asarray(fz, float) / (np.asarray(stiffness, float) * radius)
    basis = radius * np.column_stack([np.sqrt(deflection), deflection])
    half_length = np.asarray(half_length, float)
    if np.unique(np.round(deflection, 6)).size < 2:
        basis = basis[:, :1]
    found, *_ = np.linalg.lstsq(basis, half_length, rcond=None)
    error = float(np.sqrt(np.mean((basis @ found - half_length) ** 2)))
    q_ra2 = float(found[1]) if found.size > 1 else 0.0
    return ContactLength(float(found[0]), q_ra2, radius, error, found.size > 1)


def friction(steady_forces: np.ndarray, loads: np.ndarray) -> float:
    """mu: mean over conditions of |F_x,ss| at |kappa| = 10 % over F_z (section 7.2)."""
    ratio = np.abs(np.asarray(steady_forces, float)) / np.asarray(loads, float)
    ratio = ratio[np.isfinite(ratio)]
    return float(ratio.mean()) if ratio.size else math.nan
