# SPDX-License-Identifier: Apache-2.0
"""Tables of cleat, parking, turning and camber sweep: one row per run."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from flatplank_analysis.identify.results import Estimate
from flatplank_analysis.report.results import CampaignResult
from flatplank_analysis.report.table import Cell, Column, Table, point_table


def estimate(title: str, unit: str, name: str, factor: float = 1.0) -> list[Column]:
    """Value and standard error of an estimate; a dash where the run does not tell it."""

    def value(row: Any) -> Cell:
        e: Estimate = getattr(row, name)
        return factor * e.value if e.determined else math.nan

    def error(row: Any) -> Cell:
        e: Estimate = getattr(row, name)
        return abs(factor) * e.std_error if e.determined else math.nan

    return [(f"{title} [{unit}]", value), (f"± [{unit}]", error)]


def number(title: str, name: str, factor: float = 1.0) -> list[Column]:
    """A plain number of the result."""
    return [(title, lambda row: factor * getattr(row, name))]


def _table(
    kind: str, title: str, columns: Sequence[list[Column]], note: str
) -> Callable[[CampaignResult], Table]:
    def make(result: CampaignResult) -> Table:
        rows = [(r["condition"], r["found"]) for r in result.extras.get(kind, [])]
        return point_table(kind, title, rows, [c for group in columns for c in group], note)

    return make


KINDS_TABLES = (
    _table(
        "cleat",
        "Cleat",
        (
            number("height [mm]", "height", 1e3),
            number("ΔFz [N]", "rise"),
            number("ΔFz / height [kN/m]", "stiffness_over_cleat", 1e-3),
            number("dFx/dx at the middle [kN/m]", "longitudinal_stiffness", 1e-3),
            estimate("Cz of the model", "kN/m", "stiffness", 1e-3),
            estimate("cam radius", "mm", "cam_radius", 1e3),
            estimate("cam distance", "mm", "cam_distance", 1e3),
            number("RMSE Fz [N]", "rmse_fz"),
            number("RMSE Fx [N]", "rmse_fx"),
        ),
        "At a fixed axle. The effective road has the height (Fz − Fz,0)/Cz and the slope "
        "−(Fx − Fx,0)/Fz; the model is two round cams that follow the true profile (Schmeitz "
        "2004). A cleat whose record does not say its length counts as 10 mm long.",
    ),
    _table(
        "parking",
        "Parking",
        (
            estimate("C", "N m/rad", "stiffness"),
            estimate("M_max", "N m", "saturation"),
            estimate("c", "-", "exponent"),
            number("largest |Mz| [N m]", "largest"),
            number("|Mz| at 0° [N m]", "residual_moment"),
            number("work per cycle [J]", "loss"),
            number("RMSE [N m]", "rmse"),
        ),
        "Standing tire. C: slope of Mz over the steering angle where a turn begins; M_max: moment "
        "of the sliding patch; c: how late it begins to slide (van der Jagt 2000, reversals by "
        "Masing's rule).",
    ),
    _table(
        "turning",
        "Impulse turning",
        (
            estimate("C_Fα", "kN/rad", "cornering_stiffness", 1e-3),
            estimate("σy", "m", "relaxation_length"),
            estimate("a", "mm", "half_length", 1e3),
            estimate("angle left", "mrad", "angle_left", 1e3),
            number("RMSE Fy [N]", "rmse"),
            number("RMSE Mz [N m]", "rmse_moment"),
        ),
        "Linear brush of half length a on a lateral carcass spring, Fy and Mz together. Where a "
        "part of the patch slides C_Fα is that of the impulse's size, below that at zero slip. "
        "Angle left: what remains of the turn below the resolution of the steering encoder.",
    ),
    _table(
        "camber_sweep",
        "Camber sweep",
        (
            estimate("C_Fγ", "kN/rad", "camber_stiffness", 1e-3),
            estimate("σγ", "m", "relaxation_length"),
            estimate("share without lag", "%", "direct_share", 1e2),
            estimate("C_Mγ", "N m/rad", "moment_stiffness"),
            number("RMSE Fy [N]", "rmse"),
        ),
        "C_Fγ = −dFy/dγ and C_Mγ = dMz/dγ of the steady tire, one relaxation length for both, and "
        "the share of Fy that follows the camber without lag.",
    ),
)


def reference_table(result: CampaignResult) -> Table:
    """Control charts as numbers."""
    header = (
        "quantity", "unit", "sessions", "runs", "mean", "± limit", "repeatability",
        "reproducibility", "remark",
    )  # fmt: skip
    rows: list[list[Cell]] = []
    for c in result.extras.get("sessions", []):
        counts = [str(len(c.means)), str(int(c.runs.sum()))]
        numbers = [c.centre, c.reach, c.repeatability, c.reproducibility]
        rows.append([c.title, c.unit, *counts, *numbers, "; ".join(c.remarks)])
    note = (
        "Standard deviations within a session (repeatability) and between sessions beyond that "
        "(reproducibility); limits of an individuals chart, 3 x mean moving range / 1.128."
    )
    return Table("reference", "Reference tire over the sessions", header, rows, note)
