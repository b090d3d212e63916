# SPDX-License-Identifier: Apache-2.0
"""What a standing tire tells: stiffnesses as slopes of force over travel, friction of a locked
wheel."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from flatplank_control.runner.measurement import Measurement

Columns = Mapping[str, np.ndarray]
SHARE = (0.05, 0.2)
"""of Fz: tangential forces in which a tire that hardly slides is linear"""
VERTICAL = (0.35, 0.95)
"""of the largest Fz: above the play of the supports (thesis G.2)"""
SLID = 0.5
"""of the way of a locked wheel, behind which it slides"""


def slope(x: np.ndarray, y: np.ndarray) -> float:
    """dy/dx by least squares; NaN when x does not change."""
    if x.size < 5 or np.ptp(x) <= 0.0:
        return math.nan
    return float(np.polyfit(x - x.mean(), y, 1)[0])


def vertical(c: Columns, _m: Measurement) -> dict[str, float]:
    """C_z [N/m], mean of loading and unloading, and the difference between them."""
    radius, fz = c["loaded_radius"], c["fz"]
    top = int(np.argmax(fz))
    largest = float(fz[top])
    found = []
    for part in (slice(None, top + 1), slice(top, None)):
        r, f = radius[part], fz[part]
        inside = (f > VERTICAL[0] * largest) & (f < VERTICAL[1] * largest)
        found.append(-slope(r[inside], f[inside]))
    return {"stiffness": sum(found) / 2.0, "hysteresis": found[0] - found[1]}


def _tangential(c: Columns, force: np.ndarray, sense: float) -> float:
    """Slope [N/m] of a force over the road's travel times `sense`, before the tire slides."""
    size = np.hypot(c["fx"], c["fy"])
    fz = float(np.mean(c["fz"]))
    rest = c["plank_velocity"] == 0.0
    size = size - float(np.mean(size[rest])) if rest.any() else size
    beyond = np.flatnonzero(size > SHARE[1] * fz)
    last = int(beyond[0]) if beyond.size else size.size
    inside = np.flatnonzero(size[:last] > SHARE[0] * fz)
    if not inside.size:
        return math.nan
    part = slice(int(inside[0]), last)
    return -slope(c["plank_position"][part] * sense, force[part])


def longitudinal(c: Columns, m: Measurement) -> dict[str, float]:
    """C_x [N/m]: the road goes forward under a wheel that stands, so the force brakes."""
    return {"stiffness": _tangential(c, c["fx"], math.cos(math.radians(m.alpha_deg)))}


def lateral(c: Columns, m: Measurement) -> dict[str, float]:
    """C_y [N/m] from the travel across the steered wheel."""
    return {"stiffness": _tangential(c, c["fy"], math.sin(math.radians(m.alpha_deg)))}


def friction(c: Columns, _m: Measurement) -> dict[str, float]:
    """Mean friction of the sliding locked wheel, and its peak."""
    x = c["plank_position"]
    mu = np.hypot(c["fx"], c["fy"]) / c["fz"]
    sliding = x > x[0] + SLID * (x[-1] - x[0])
    return {"friction": float(mu[sliding].mean()), "peak_friction": float(mu.max())}


EVALUATIONS: dict[str, Callable[[Columns, Measurement], dict[str, float]]] = {
    "stiffness_vertical": vertical,
    "stiffness_longitudinal": longitudinal,
    "stiffness_lateral": lateral,
    "locked_wheel": friction,
}
"""kind of measurement -> what its run tells [SI]"""
