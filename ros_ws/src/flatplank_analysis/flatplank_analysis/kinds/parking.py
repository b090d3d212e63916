# SPDX-License-Identifier: Apache-2.0
"""Parking: aligning moment of a standing tire over its steering angle.

The contact patch twists with the wheel until it slides. Model of P. van der Jagt (The Road to
Virtual Vehicle Prototyping, TU Eindhoven 2000):

    first turn:        M = f(psi),   df/dpsi = C (1 - (f / M_max)^c)
    after a reversal:  M = M_r +- 2 f(|psi - psi_r| / 2)

The second line is Masing's rule (G. Masing, 1926): at a reversal sticking and sliding parts change
sign one by one, so that the returning branch is the first one, doubled.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flatplank_analysis.identify.results import Estimate
from flatplank_analysis.kinds.record_fit import FitParameter, fit_record
from flatplank_data.errors import FlatplankError
from flatplank_data.table import MeasurementTable

SPACING = math.radians(0.25)
"""spacing of the grid of turned angle [rad]"""
LEAST_TURN = math.radians(1.0)
"""smallest turn that is fitted [rad]"""
GRID = 200
"""points of the curve of the first turn"""


@dataclass(frozen=True)
class Parking:
    """Results of one parking run; angle and moments of shape (n,) over the turned angle."""

    stiffness: Estimate
    """C, slope of the moment at a reversal [N m/rad]"""
    saturation: Estimate
    """M_max of the sliding patch [N m]"""
    exponent: Estimate
    """c [-]: the larger, the later the patch begins to slide"""
    largest: float
    """largest absolute moment, relative to that before the first turn [N m]"""
    loss: float
    """work per full cycle [J]; NaN without a full cycle"""
    residual_moment: float
    """mean absolute moment at zero angle, hysteresis [N m]"""
    angle: np.ndarray
    moment: np.ndarray
    modelled: np.ndarray
    rmse: float
    """[N m]"""


def parking(table: MeasurementTable) -> Parking:
    """Fit one run. Raises FlatplankError where the steering angle does not change."""
    angle, moment = _over_turned_angle(table)
    growth = np.diff(angle, prepend=angle[0])
    # the road resists the turn; the sign depends on the axes of the angle
    sign = 1.0 if float(growth @ np.gradient(moment)) >= 0.0 else -1.0
    size = max(float(np.ptp(moment)) / 2.0, 1.0)
    unknowns = (
        FitParameter("C", "N m/rad", 4.0 * size / max(float(np.ptp(angle)), 1e-3), 1.0, 1e6),
        FitParameter("M_max", "N m", 1.2 * size, 0.1 * size, 20.0 * size),
        FitParameter("c", "-", 1.0, 0.2, 8.0),
    )

    def model(sets: np.ndarray) -> dict[str, np.ndarray]:
        c, top, power = sets.T
        return {"mz": moment[0] + sign * twisted(angle, c, top, power)}

    fit = fit_record(model, {"mz": moment}, unknowns)
    free = moment - moment[0]
    return Parking(
        fit.estimates["C"],
        fit.estimates["M_max"],
        fit.estimates["c"],
        float(np.max(np.abs(free))),
        _loss(angle, sign * free),
        _at_zero(angle, free),
        angle,
        moment,
        fit.modelled["mz"],
        fit.rmse["mz"],
    )


def twisted(
    angle: np.ndarray, stiffness: np.ndarray, largest: np.ndarray, power: np.ndarray
) -> np.ndarray:
    """Moment (sets, n) of the model over angles (n,) [rad]; the parameters of shape (sets,)."""
    reach = np.linspace(0.0, float(np.ptp(angle)) + 1e-9, GRID)
    first = _first_turn(reach, stiffness, largest, power)
    out = np.zeros((len(stiffness), len(angle)))
    for begin, end in _branches(angle):
        way = np.abs(angle[begin : end + 1] - angle[begin])
        factor = 1.0 if begin == 0 else 2.0
        way_up = np.sign(angle[end] - angle[begin])
        for row, curve in zip(out, first, strict=True):
            grown = factor * np.interp(way / factor, reach, curve)
            row[begin : end + 1] = row[begin] + way_up * grown
    return np.clip(out, -largest[:, None], largest[:, None])


def _first_turn(
    reach: np.ndarray, stiffness: np.ndarray, largest: np.ndarray, power: np.ndarray
) -> np.ndarray:
    """f (sets, m) over angles (m,) by the midpoint rule."""
    f = np.zeros((len(stiffness), len(reach)))
    step = reach[1] - reach[0]

    def slope(m: np.ndarray) -> np.ndarray:
        return stiffness * (1.0 - np.clip(m / largest, 0.0, 1.0) ** power)

    for i in range(1, len(reach)):
        half = f[:, i - 1] + 0.5 * step * slope(f[:, i - 1])
        f[:, i] = np.minimum(f[:, i - 1] + step * slope(half), largest)
    return f


def _branches(angle: np.ndarray) -> list[tuple[int, int]]:
    """First and last sample of each branch in one direction; none is shorter than SPACING."""
    ends, latest = [0], 0
    for i, way in enumerate(np.sign(np.diff(angle))):
        if way and latest and way != latest and abs(angle[i] - angle[ends[-1]]) > SPACING:
            ends.append(i)
        latest = way or latest
    return list(zip(ends, [*ends[1:], len(angle) - 1], strict=True))


def _over_turned_angle(table: MeasurementTable) -> tuple[np.ndarray, np.ndarray]:
    """Angle [rad] and moment [N m], averaged in uniform cells of turned angle."""
    angle, moment = table["steer_angle"], table["mz"]
    good = np.isfinite(angle) & np.isfinite(moment)
    angle, moment = angle[good], moment[good]
    turned = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(angle)))])
    if not turned.size or turned[-1] < LEAST_TURN:
        raise FlatplankError(
            "the steering angle does not move", table.info.file, "record steer_angle [rad]"
        )
    cell = np.floor(turned / SPACING).astype(int)
    number = np.bincount(cell)
    full = number > 0
    means = [np.bincount(cell, weights=v)[full] / number[full] for v in (angle, moment)]
    return means[0], means[1]


def _loss(angle: np.ndarray, moment: np.ndarray) -> float:
    """Work of a full cycle [J]: twice that between the two outermost angles."""
    high, low = int(np.argmax(angle)), int(np.argmin(angle))
    first, last = min(high, low), max(high, low)
    if angle[high] <= 0.0 or angle[low] >= 0.0 or last - first < 5:
        return math.nan
    way, force = angle[first : last + 1], moment[first : last + 1]
    return 2.0 * abs(float(np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(way))))


def _at_zero(angle: np.ndarray, moment: np.ndarray) -> float:
    """Mean |moment| at passages of the angle through zero after the first reversal [N m]."""
    passages = np.flatnonzero(np.diff(np.sign(angle)) != 0)
    first = int(np.argmax(np.abs(angle) >= 0.98 * np.max(np.abs(angle))))
    later = [i for i in passages if i > first]
    return float(np.mean(np.abs(moment[later]))) if later else math.nan
