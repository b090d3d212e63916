# SPDX-License-Identifier: Apache-2.0
"""Effective rolling radius (5.22) at zero force, and the settling distance of a run (Appendix E).

Three sources are compared, because the thesis found 0.3108 m with the controller and 0.3081 m with
the flexplates off. The free-rolling controller holds Fx at 50 N, slip control holds a speed, and a
wheel without flexplates rolls against its own resistance. At a force F the tire slips by F / C_Fk.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from flatplank_data.condition import Condition
from flatplank_data.machine import GEAR_RATIO, USABLE_ROAD
from flatplank_data.table import MeasurementTable

STEADY_FROM = 1.54
"""road displacement from which a free-rolling run has settled, thesis 5.6 [m]"""
BRAKING = 0.02
"""road at the end of a run on which plank and wheel brake one after the other [m]"""
FREE_WHEEL = "flexplates_off"
SOURCES = ("controller", "slip_control", FREE_WHEEL)


@dataclass(frozen=True)
class RadiusRun:
    """r_e of one run."""

    condition: Condition
    source: str
    radius: float
    """r_e by (5.22), not corrected for Fx [m]"""
    force: float
    """mean Fx over the same road [N]"""
    load: float
    """mean Fz over the same road [N]; nominal where it was not measured"""
    start: int = 1
    """1, 2, 3: wheel started at 0, 120, 240 deg"""

    def corrected(self, slip_stiffness: float) -> float:
        """r_e at Fx = 0: r_e (1 + F / C_Fk), with C_Fk [N]."""
        return self.radius * (1.0 + self.force / slip_stiffness)


def radius_of_run(table: MeasurementTable) -> RadiusRun:
    """r_e from the road on which a run rolls freely."""
    info, x = table.info, table["plank_position"]
    source = "controller" if info.measurement == "free_rolling" else "slip_control"
    source = info.r_e_source if info.r_e_source in SOURCES else source
    first, last = STEADY_FROM, float(x.max()) - BRAKING
    if info.measurement == "slip":
        step = info.step_position if math.isfinite(info.step_position) else last
        first, last = (step - 0.4, step) if info.kappa else (step, last)
    keep = (x >= first) & (x <= last)
    if keep.sum() < 10:
        keep = x >= 0.6 * float(x.max())
    cosine = math.cos(math.radians(info.alpha_deg))
    time = table["time"][keep]
    speed = float(np.ptp(x[keep])) / float(np.ptp(time))
    encoder = _over(speed * cosine, _rate(table, "wheel_angle", "wheel_velocity", keep))
    motor = _over(GEAR_RATIO * speed * cosine, _rate(table, "", "motor_velocity", keep))
    radius = encoder if source == FREE_WHEEL or math.isnan(motor) else motor
    load = float(np.mean(table["fz"][keep])) if table.has("fz") else info.fz
    force = float(np.mean(table["fx"][keep]))
    return RadiusRun(info.condition, source, radius, force, load, info.start)


def _over(speed: float, omega: float) -> float:
    return speed / omega if omega else math.nan


def _rate(table: MeasurementTable, angle: str, velocity: str, keep: np.ndarray) -> float:
    """Mean angular velocity [rad/s], from the angle where there is one."""
    time = table["time"][keep]
    if angle and table.has(angle):
        return float(np.polyfit(time - time.mean(), table[angle][keep], 1)[0])
    if table.has(velocity):
        return float(np.trapezoid(table[velocity][keep], time) / np.ptp(time))
    return math.nan


REFERENCE_FORCE = 50.0
"""y_ref of the free-rolling controller [N]"""
BAND = 0.05
"""a force within this share of its reference has settled [-]"""
FIT_RANGE = (0.1, USABLE_ROAD)
"""road displacement that is fitted [m]"""
RATES = np.geomspace(0.1, 100.0, 61)
"""values of p2 that are tried before the search is refined [1/m]"""


@dataclass(frozen=True)
class ExponentialFit:
    """y(x) = p1 exp(-p2 x) + p3 (E.1); p1, p3 [N], p2 [1/m]."""

    p1: float
    p2: float
    p3: float
    rmse: float

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """Fitted force [N] at road displacement `x` [m]."""
        return self.p1 * np.exp(-self.p2 * np.asarray(x)) + self.p3

    def settles_at(self, reference: float = REFERENCE_FORCE, band: float = BAND) -> float:
        """Displacement from which |y_ref - y| <= band y_ref [m]; NaN when it never settles."""
        limit = band * abs(reference)
        room = limit - math.copysign(1.0, self.p1) * (self.p3 - reference)
        if abs(self.p3 - reference) > limit or self.p2 <= 0.0:
            return math.nan
        if self.p1 == 0.0 or abs(self.p1) <= room:
            return 0.0
        return math.log(abs(self.p1) / room) / self.p2 if room > 0.0 else math.inf


def fit_exponential(x: np.ndarray, y: np.ndarray) -> ExponentialFit:
    """Least squares fit of (E.1); p1 and p3 are linear, so only p2 is searched."""
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    keep = (x >= FIT_RANGE[0]) & (x <= FIT_RANGE[1]) & np.isfinite(y)
    x, y = x[keep], y[keep]

    def solve(log_rate: float) -> tuple[float, np.ndarray]:
        basis = np.column_stack([np.exp(-math.exp(log_rate) * x), np.ones_like(x)])
        coefficients, *_ = np.linalg.lstsq(basis, y, rcond=None)
        return float(np.mean((basis @ coefficients - y) ** 2)), coefficients

    logs = np.log(RATES)
    best = int(np.argmin([solve(value)[0] for value in logs]))
    bounds = (logs[max(best - 1, 0)], logs[min(best + 1, logs.size - 1)])
    found = minimize_scalar(lambda v: solve(v)[0], bounds=bounds, method="bounded")
    cost, (p1, p3) = solve(float(found.x))
    return ExponentialFit(float(p1), math.exp(found.x), float(p3), math.sqrt(cost))
