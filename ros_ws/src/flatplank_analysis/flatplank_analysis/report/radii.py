# SPDX-License-Identifier: Apache-2.0
"""Effective rolling radius by operating point and source, and the differences between sources."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations
from typing import NamedTuple

from flatplank_analysis.report.results import CampaignResult
from flatplank_analysis.report.steps import slip_stiffness
from flatplank_analysis.report.table import Table, point_table
from flatplank_analysis.steady.rolling_radius import FREE_WHEEL, RadiusValue, mean_radii
from flatplank_data.condition import Condition

OF_THE_THESIS = (
    "The thesis (5.6, 8.2) has 310.8 mm by the controller and 308.1 mm for the free wheel, "
    "+0.88 %. 50 N explain 0.055 % of it, with the other sign: a driven wheel turns faster, a "
    "free one holds the road back, so that the free wheel has the larger radius. The rest is no "
    "property of the tire: it would take 0.9 % of C_Fκ, about 800 N, or an error of a speed."
)
"""what is known of the difference that the thesis leaves open"""
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


class RadiusPair(NamedTuple):
    """r_e of one operating point from two sources."""

    one: RadiusValue
    other: RadiusValue

    @property
    def whole(self) -> float:
        """Difference of the first from the second, relative to it."""
        return self.one.measured.value / self.other.measured.value - 1.0

    @property
    def left(self) -> float:
        """The same at Fx = 0."""
        return self.one.corrected.value / self.other.corrected.value - 1.0

    @property
    def names(self) -> str:
        """Both sources in words."""
        return f"{self.one.source} − {self.other.source}".replace("_", " ")


def radius_pairs(result: CampaignResult) -> list[RadiusPair]:
    """Every two sources of an operating point; a free wheel is the second one."""
    groups: dict[Condition, list[RadiusValue]] = {}
    for value in sorted(radius_values(result), key=lambda v: v.source == FREE_WHEEL):
        groups.setdefault(value.point, []).append(value)
    return [RadiusPair(*two) for values in groups.values() for two in combinations(values, 2)]


def source_table(result: CampaignResult) -> Table:
    """Differences of r_e between the sources, a question of the thesis."""
    pairs = radius_pairs(result)
    columns = (
        ("sources", lambda p: p.names),
        ("difference [%]", lambda p: 100.0 * p.whole),
        ("by the force [%]", lambda p: 100.0 * (p.whole - p.left)),
        ("left [%]", lambda p: 100.0 * p.left),
        (
            "left as force [N]",
            lambda p: p.left * max(p.one.slip_stiffness, p.other.slip_stiffness),
        ),
        ("reading", lambda p: _explanation(p.one, p.other, p.left)),
    )
    note = (
        "First source less the second. By the force: Fx differs, and F makes a slip F/C_Fκ. What "
        "is left would need an error of Fx of that size, or belongs to the encoders. "
        f"{free_wheel_text(pairs)} {OF_THE_THESIS}"
    )
    rows = [(pair.one.point, pair) for pair in pairs]
    return point_table("radius_sources", "Why rolling radii differ", rows, columns, note)


def free_wheel_text(pairs: Sequence[RadiusPair]) -> str:
    """The radius of the free wheel against the controlled one, in words."""
    free = [p for p in pairs if p.other.source == FREE_WHEEL and math.isfinite(p.left)]
    if not free:
        return "No operating point was measured with the flexplates off and otherwise, too."
    p = max(free, key=lambda p: abs(p.left))
    return (
        f"The controlled radius is {100.0 * p.whole:+.2g} % from that of the free wheel "
        f"({1e3 * p.one.measured.value:.2f} and {1e3 * p.other.measured.value:.2f} mm; "
        f"{p.names}), {100.0 * (p.whole - p.left):+.2g} % by the forces of {p.one.force:.0f} and "
        f"{p.other.force:.0f} N, {100.0 * p.left:+.2g} % is left."
    )


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
