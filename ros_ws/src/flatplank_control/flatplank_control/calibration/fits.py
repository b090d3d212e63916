# SPDX-License-Identifier: Apache-2.0
"""Fits for calibrations: a straight line, the once-per-turn force, check of a parasitic fit."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np


class Line(NamedTuple):
    """y = offset + slope x, with standard errors."""

    slope: float
    offset: float
    slope_error: float
    offset_error: float
    residual: float
    """rms residual, in the unit of y"""


def fit_line(pairs: Sequence[tuple[float, float]], reading: float = 0.0) -> Line:
    """Least-squares line through (x, y); `reading`: uncertainty of one y, used when two points
    leave no residual."""
    x = np.array([p[0] for p in pairs], float)
    y = np.array([p[1] for p in pairs], float)
    if not (np.isfinite(x).all() and np.isfinite(y).all()):
        raise ValueError("calibration: a reading is no number; read it again")
    if x.size < 2 or np.ptp(x) <= 0.0:
        raise ValueError("calibration: give at least two different points, as in 0:0.1,1000:996")
    centre = x - x.mean()
    spread = float(centre @ centre)
    slope = float(centre @ y) / spread
    offset = float(y.mean() - slope * x.mean())
    left = y - offset - slope * x
    freedom = x.size - 2
    scatter = math.sqrt(float(left @ left) / freedom) if freedom else 0.0
    sigma = max(scatter, reading)
    return Line(
        slope, offset, sigma / math.sqrt(spread),
        sigma * math.sqrt(1.0 / x.size + x.mean() ** 2 / spread),
        float(np.sqrt(np.mean(left**2))),
    )  # fmt: skip


def turning_amplitude(
    angle: np.ndarray, force: np.ndarray, drift: np.ndarray | None = None
) -> np.ndarray:
    """Once-per-turn amplitude [N] of a force over the wheel angle [rad], fitted with a mean and,
    if `drift` is given, a drift over it. `force` has shape (n,) or (n, k), the amplitude () or
    (k,)."""
    columns = [np.ones_like(angle), np.sin(angle), np.cos(angle)]
    if drift is not None:
        columns.insert(1, drift - drift.mean())
    a = np.linalg.lstsq(np.column_stack(columns), force, rcond=None)[0]
    return np.hypot(a[-2], a[-1])


MISMATCH = 40.0
"""once-per-turn force with filter above which the fit does not belong to the mounting [N]"""


def mounting_warning(left: float) -> str:
    """A warning when the once-per-turn force [N] with the filter on indicates another mounting;
    else empty."""
    if not left > MISMATCH:
        return ""
    return (
        f"{left:.0f} N once per turn are left with the filter on (at most {MISMATCH:g} N): "
        "the fit is not that of this mounting; make the unloaded turn again"
    )


def amplitudes_under_load(
    plain: Mapping[str, np.ndarray], filtered: Mapping[str, np.ndarray], first: float, last: float
) -> dict[str, tuple[float, float]]:
    """Once-per-turn amplitude of Fx and Fz [N] without and with the filter, from two equal runs
    between two plank positions [m] (Figures C.5, C.6)."""
    found = {}
    for name in ("fx", "fz"):
        both = []
        for run in (plain, filtered):
            inside = (run["plank_position"] >= first) & (run["plank_position"] < last)
            angle = run["wheel_angle"][inside]
            both.append(float(turning_amplitude(angle, run[name][inside], drift=angle)))
        found[name] = (both[0], both[1])
    return found


def amplitude_lines(found: Mapping[str, tuple[float, float]]) -> Sequence[str]:
    """Lines for the terminal: the amplitude of each force without and with the filter."""
    return [f"{name}: {a:.1f} N once per turn, {b:.1f} N filtered" for name, (a, b) in
            found.items()]  # fmt: skip
