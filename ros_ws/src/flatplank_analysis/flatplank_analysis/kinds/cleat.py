# SPDX-License-Identifier: Apache-2.0
"""Rolling over a cleat at a fixed axle height: effective height and slope of the road.

A tire on a short obstacle experiences an effective road: a height w and a slope, which follow from
the forces at a fixed axle, Fz = Fz_0 + C_z w and Fx = Fx_0 - Fz dw/dx. Model: two cams, one
behind the other, follow the true profile (A. J. C. Schmeitz, A Semi-Empirical Three-Dimensional
Model of the Pneumatic Tyre Rolling over Arbitrarily Uneven Road Surfaces, TU Delft 2004); w is the
mean of their heights, the slope their difference over their distance.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from flatplank_analysis.identify.results import Estimate
from flatplank_analysis.kinds.record_fit import FitParameter, fit_record
from flatplank_analysis.post.gridding import bin_means
from flatplank_data.errors import FlatplankError
from flatplank_data.table import MeasurementTable

SPACING = 0.002
"""spacing of the grid over travel [m]"""
AROUND = 0.3
"""road on both sides of the cleat that is fitted [m]"""
LEAST_RISE = 5.0
"""least rise of Fz over its scatter before the cleat [-]"""
LENGTH = 0.01
"""assumed length of a cleat whose record does not state it [m]"""


@dataclass(frozen=True)
class Cleat:
    """Results of one pass; arrays of shape (n,) over travel since the cleat's middle."""

    height: float
    """height of the cleat [m]"""
    stiffness: Estimate
    """C_z of the model: load per effective height [N/m]"""
    cam_radius: Estimate
    """[m]"""
    cam_distance: Estimate
    """[m]"""
    middle: Estimate
    """plank position of the cleat's middle [m]"""
    rise: float
    """largest change of Fz [N]"""
    stiffness_over_cleat: float
    """rise over cleat height [N/m]"""
    fx_slope: float = field(metadata={"json": "longitudinal_stiffness"})
    """slope of Fx over travel at the middle of the cleat [N/m]"""
    distance: np.ndarray
    """[m]"""
    effective_height: np.ndarray
    """w from Fz and C_z [m]"""
    effective_slope: np.ndarray
    """from Fx over Fz [-]"""
    fx: np.ndarray
    fz: np.ndarray
    fx_modelled: np.ndarray
    fz_modelled: np.ndarray
    rmse_fx: float
    rmse_fz: float


def cleat(table: MeasurementTable) -> Cleat:
    """Fit one pass. Raises FlatplankError where load or record do not show the cleat."""
    given = dict(table.info.parameters.get("measurement", {}))
    height, length = 1e-3 * float(given.get("cleat_mm", math.nan)), LENGTH
    if not height > 0.0:
        raise FlatplankError(
            "the record has no height of the cleat",
            table.info.file,
            "write parameters: {measurement: {cleat_mm: ...}}",
        )
    x, fx, fz = _near_cleat(table)
    unknowns = (
        FitParameter("C_z", "N/m", float(np.ptp(fz)) / height, 1e4, 2e6),
        FitParameter("R_cam", "m", 0.3, 0.02, 3.0),
        FitParameter("l_s", "m", 0.05, 0.002, 0.3),
        FitParameter("x_0", "m", 0.0, -0.05, 0.05),
        FitParameter("F_x0", "N", float(np.median(fx)), -2e3, 2e3),
        FitParameter("F_z0", "N", float(np.median(fz)), 0.0, 2e4),
    )

    def model(sets: np.ndarray) -> dict[str, np.ndarray]:
        c_z, radius, apart, middle, f_x0, f_z0 = sets.T[:, :, None]
        w, slope = envelope(x - middle, height, length, radius, apart)
        load = f_z0 + c_z * w
        return {"fz": load, "fx": f_x0 - load * slope}

    fit = fit_record(model, {"fz": fz, "fx": fx}, unknowns)
    found = fit.estimates
    level, drag = found["F_z0"].value, found["F_x0"].value
    at = x - found["x_0"].value
    near = np.abs(at) < 0.015
    place = replace(found["x_0"], value=found["x_0"].value + _peak(table))
    return Cleat(
        height, found["C_z"], found["R_cam"], found["l_s"], place,
        float(np.max(fz) - level), float(np.max(fz) - level) / height,
        float(np.polyfit(at[near], fx[near], 1)[0]),
        at, (fz - level) / found["C_z"].value, -(fx - drag) / fz,
        fx, fz, fit.modelled["fx"], fit.modelled["fz"], fit.rmse["fx"], fit.rmse["fz"],
    )  # fmt: skip


def envelope(
    x: np.ndarray, height: float, length: float, radius: np.ndarray, apart: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Effective height [m] and slope [-] of the road under two cams, each (sets, n).

    x: distance of the cams' middle from that of the cleat (sets, n) [m]; `radius` of the cams and
    their distance `apart` (sets, 1) [m]. The cleat has upright sides.
    """
    front, rear = (_cam(x + s * 0.5 * apart, height, length, radius) for s in (1.0, -1.0))
    return 0.5 * (front + rear), (front - rear) / apart


def _cam(x: np.ndarray, height: float, length: float, radius: np.ndarray) -> np.ndarray:
    """Height of a round cam's lowest point above the road when its middle is at x [m]."""
    beside = np.minimum(np.maximum(np.abs(x) - 0.5 * length, 0.0), radius)
    return np.maximum(height - radius + np.sqrt(radius**2 - beside**2), 0.0)


def _peak(table: MeasurementTable) -> float:
    """Plank position of the largest load [m]."""
    x, fz = bin_means(table["plank_position"], table["fz"], 0.005)
    return float(x[int(np.argmax(fz))])


def _near_cleat(table: MeasurementTable) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Travel since the largest load [m], Fx and Fz [N] around the cleat."""
    rows = np.vstack([table["fx"], table["fz"]])
    distance, (fx, fz) = bin_means(table["plank_position"] - _peak(table), rows, SPACING)
    near = np.abs(distance) <= AROUND
    before = fz[near & (distance < -0.5 * AROUND)]
    rise = float(np.max(fz)) - float(np.median(fz))
    if before.size < 8 or rise < LEAST_RISE * max(float(np.std(before)), 1.0):
        raise FlatplankError(
            "the load shows no cleat",
            table.info.file,
            "was it fastened, and is its road recorded?",
        )
    return distance[near], fx[near], fz[near]
