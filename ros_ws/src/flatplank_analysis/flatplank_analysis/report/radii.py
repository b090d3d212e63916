# SPDX-License-Identifier: Apache-2.0
"""Effective rolling radius by operating point and source, and the differences between sources."""

from __future__ import annotations

import math
from itertools import combinations

from flatplank_analysis.report.results import CampaignResult
from flatplank_analysis.report.steps import slip_stiffness
from flatplank_analysis.report.table import Table, point_table
from flatplank_analysis.steady.rolling_radius import FREE_WHEEL, RadiusValue, mean_radii
from flatplank_data.condition import Condition

FLAT = 2e-4
"""Relative difference below which radii agree [-]."""


def radius_values(result: CampaignResult) -> list[RadiusValue]:
    """r_e by operating point and source; corrected with the slip stiffness of that point, where
    it is not known with that of the others."""
    stiffness = {p.point: slip_stiffness(p) for p in result.points}
    known = [v for v in stiffness.values() if math.isfinite(v)]
    usual = sum(known) / len(known) if known else math.nan
    usual_at = {point: v if math.isfinite(v) else usual for point, v in stiffness.items()}
    return mean_radii(result.radii, usual_at)


def radius_table(result: CampaignResult) -> Table:
    """Figures 6.1, 6.2 as numbers, sources side by side."""
    columns = (
        ("source", lambda v: v.source.replace("_", " ")),
        ("r_e [mm]", lambda v: 1e3 * v.measured.value),
        ("± [mm]", lambda v: 1e3 * v.measured.std_error),
        ("Fx [N]", lambda v: v.force),
        ("r_e at Fx = 0 [mm]", lambda v: 1e3 * v.corrected.value),
        ("runs", lambda v: str(v.measured.runs)),
        ("remark", lambda v: v.corrected.note),
    )
    rows = [(v.point, v) for v in radius_values(result)]
    note = "By (5.22). A force F makes a slip F/C_Fκ: r_e at Fx = 0 is r_e (1 + F/C_Fκ)."
    return point_table("rolling_radius", "Effective rolling radius", rows, columns, note)


def source_table(result: CampaignResult) -> Table:
    """Differences of r_e between the sources, a question of the thesis."""
    groups: dict[Condition, list[RadiusValue]] = {}
    for value in radius_values(result):
        groups.setdefault(value.point, []).append(value)
    rows = []
    for point, values in groups.items():
        for one, other in combinations(values, 2):
            whole = one.measured.value / other.measured.value - 1.0
            left = one.corrected.value / other.corrected.value - 1.0
            rows.append((point, (one, other, whole, left)))
    columns = (
        ("sources", lambda p: f"{p[0].source} − {p[1].source}".replace("_", " ")),
        ("difference [%]", lambda p: 100.0 * p[2]),
        ("by the force [%]", lambda p: 100.0 * (p[2] - p[3])),
        ("left [%]", lambda p: 100.0 * p[3]),
        ("left as force [N]", lambda p: p[3] * max(p[0].slip_stiffness, p[1].slip_stiffness)),
        ("reading", lambda p: _explanation(p[0], p[1], p[3])),
    )
    note = (
        "First source less the second. By the force: Fx differs, and F makes a slip F/C_Fκ. What "
        "is left would need an error of Fx of that size, or belongs to the encoders."
    )
    return point_table("radius_sources", "Why rolling radii differ", rows, columns, note)


def _explanation(one: RadiusValue, other: RadiusValue, left: float) -> str:
    """Explanation of the remaining difference, as far as these runs allow."""
    if not math.isfinite(left):
        return "no slip stiffness: the force's share is not known"
    error = math.hypot(_relative(one), _relative(other))
    if abs(left) < FLAT or (error > 0.0 and abs(left) < 2.0 * error):
        return "the force explains it"
    if FREE_WHEEL in (one.source, other.source):
        return "free wheel: measured by the wheel encoder, the others by the motor's"
    fewest = min(one, other, key=lambda v: v.starts)
    if fewest.starts < 3:
        return (
            f"{fewest.source.replace('_', ' ')} from {fewest.starts} of three start angles: "
            "an Fx error that turns with the wheel stays in it"
        )
    return "not explained by the force: look at zero and gain of Fx"


def _relative(value: RadiusValue) -> float:
    error = value.measured.std_error
    return error / value.measured.value if math.isfinite(error) else 0.0
