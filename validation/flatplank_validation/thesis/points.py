# SPDX-License-Identifier: Apache-2.0
"""Operating points and conditions of the matrix by their values, and findings in words."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flatplank_analysis.figures import pieces
from flatplank_analysis.report.radii import radius_values
from flatplank_analysis.report.results import CampaignResult, ConditionResult, PointResult
from flatplank_data.errors import FlatplankError

FZ0, P0 = 3700.0, 2.5
"""nominal load [N] and pressure [bar] of the Toyo"""
LOADS, ANGLES = (1850.0, 3700.0, 5550.0), (0.0, 1.0, 5.0, 10.0)
SLIPS = (-0.10, -0.05, -0.02, -0.01, 0.0, 0.01, 0.02, 0.05, 0.10)
TAIL = 0.5
"""road over which a force at the end of a run is averaged [m]"""


def point(
    result: CampaignResult,
    fz: float = FZ0,
    bar: float = P0,
    alpha: float = 0.0,
    gamma: float = 0.0,
) -> PointResult:
    """The operating point with these values; FlatplankError where it was not measured."""
    for p in result.points:
        c = p.point
        if (c.fz, c.pressure, c.alpha_deg, c.gamma_deg) == (fz, bar, alpha, gamma):
            return p
    what = f"no operating point of {fz:g} N, {bar:g} bar, {alpha:g}°, {gamma:g}°"
    raise FlatplankError(what, result.path, "measure it")


def at(result: CampaignResult, kappa: float, **where: float) -> ConditionResult:
    """The slip level `kappa` of an operating point."""
    found = pieces.at_slip(point(result, **where), kappa)
    if found is None:
        raise FlatplankError(f"no slip of {100 * kappa:g} %", result.path, "measure it")
    return found


def end_force(c: ConditionResult, channel: str = "fx") -> float:
    """Mean force over the last half metre [N]."""
    x, force = c.position, c.measured[channel]
    good = np.isfinite(force)
    x, force = x[good], force[good]
    return float(np.mean(force[x > x[-1] - TAIL]))


def mean_force(c: ConditionResult, first: float, last: float, channel: str = "fx") -> float:
    """Mean force between two distances since the step [m]."""
    keep = (c.since_step >= first) & (c.since_step < last) & np.isfinite(c.measured[channel])
    return float(np.mean(c.measured[channel][keep]))


def reaches(c: ConditionResult, share: float = 0.9) -> float:
    """Road after which Fx has first made `share` of its change [m]."""
    x = c.since_step
    start, end = mean_force(c, -0.1, 0.0), end_force(c)
    progress = (c.measured["fx"] - start) / (end - start)
    there = np.flatnonzero((x > 0.0) & (progress >= share))
    return float(x[there[0]]) if there.size else float("nan")


def trend(values: Sequence[float]) -> str:
    """How values go, in the order given: rises, falls, or both."""
    steps = np.sign(np.diff(np.asarray(values, float)))
    words = {1.0: "rises", -1.0: "falls", 0.0: "stays"}
    told = [words[float(s)] for s in steps if s]
    short = [w for k, w in enumerate(told) if k == 0 or w != told[k - 1]]
    return ", then ".join(short) if len(short) <= 2 else "goes up and down"


def radius(result: CampaignResult, source: str = "controller", **where: float) -> float:
    """r_e by (5.22) of an operating point, mean over the start angles [m]."""
    wanted = point(result, **where).point
    for v in radius_values(result):
        if v.point == wanted and v.source == source:
            return v.measured.value
    raise FlatplankError(f"no r_e from {source} at {wanted.label()}", result.path, "measure it")
