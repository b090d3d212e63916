# SPDX-License-Identifier: Apache-2.0
"""Rolling radius (6.1, 6.2), settling (E.1), stiffness and contact (App. G), friction (5.3)."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from flatplank_analysis.figures import pieces
from flatplank_analysis.figures.registry import maker
from flatplank_analysis.figures.spec import Figure, Panel, Series
from flatplank_analysis.figures.style import INK, PALETTE
from flatplank_analysis.models.magic_formula import Coefficients
from flatplank_analysis.models.magic_formula.structure import effective_radius
from flatplank_analysis.post.settling import ExponentialFit
from flatplank_analysis.report.radii import radius_values
from flatplank_analysis.report.results import CampaignResult
from flatplank_data.condition import Condition


@maker("radius")
def rolling_radius(result: CampaignResult) -> Iterator[Figure]:
    """r_e over load per pressure and source, and over side slip per camber."""
    values = radius_values(result)
    straight = [v for v in values if not v.point.alpha_deg and not v.point.gamma_deg]
    panels = []
    if len({v.point.fz for v in straight}) > 1:
        panels.append(_lines(straight, "fz", "pressure", "vertical force Fz [N]", "{:g} bar"))
    nominal = result.nominal()
    turned = [v for v in values if nominal and _same_load(v.point, nominal.point)]
    if len({v.point.alpha_deg for v in turned}) > 1:
        panels.append(_lines(turned, "alpha_deg", "gamma_deg", "side slip angle α [°]", "γ {:g}°"))
    if panels:
        caption = "By (5.22), mean over the start angles, corrected to Fx = 0 with C_Fκ."
        yield Figure("rolling_radius", "Effective rolling radius", caption, panels, "6.1, 6.2")


@maker("radius")
def modelled_radius(result: CampaignResult) -> Iterator[Figure]:
    """Figures 7.30, 7.31: measured r_e beside the Magic Formula's, over load."""
    if result.magic is None or "re" not in result.magic.fits:
        return
    c = result.magic.tir.coefficients
    straight = [
        v for v in radius_values(result) if not v.point.alpha_deg and not v.point.gamma_deg
    ]
    series = []
    for bar, color in zip(sorted({v.point.pressure for v in straight}), PALETTE, strict=False):
        mine = [v for v in straight if v.point.pressure == bar]
        x = np.array([v.point.fz for v in mine])
        y = np.array([1e3 * v.corrected.value for v in mine])
        there = partial(_radius_mm, c, bar)
        reach = (0.7 * x.min(), 1.2 * x.max())
        series += pieces.with_model(f"{bar:g} bar", color, (x, y), reach, there)
    if series:
        caption = "Points: measured, at Fx = 0. Lines: the fitted coefficients."
        panel = Panel("vertical force Fz [N]", "effective rolling radius [mm]", series)
        title = "Rolling radius, measured and modelled"
        yield Figure("rolling_radius_model", title, caption, (panel,), "7.30")


def _radius_mm(c: Coefficients, bar: float, fz: np.ndarray) -> np.ndarray:
    return 1e3 * effective_radius(c, pieces.at_point(c, fz, 0.0, 0.0, 0.0, bar), 0.0)


def _same_load(one: Condition, other: Condition) -> bool:
    return (one.fz, one.pressure) == (other.fz, other.pressure)


def _lines(values, over: str, split: str, x_label: str, label: str) -> Panel:
    series = []
    groups: dict[tuple, list] = {}
    for value in values:
        key = (getattr(value.point, split), value.source)
        groups.setdefault(key, []).append(value)
    for (level, source), members in sorted(groups.items()):
        members.sort(key=lambda v: getattr(v.point, over))
        x = np.array([getattr(v.point, over) for v in members])
        y = np.array([1e3 * v.corrected.value for v in members])
        error = np.nan_to_num(np.array([1e3 * v.corrected.std_error for v in members]))
        text = f"{label.format(level)}, {source.replace('_', ' ')}"
        series.append(Series(text, x, y, "joined", error=error))
    return Panel(x_label, "effective rolling radius [mm]", series)


@maker("radius")
def settling(result: CampaignResult) -> Iterator[Figure]:
    """Free-rolling runs with the exponential of Appendix E."""
    runs = result.extras.get("free_rolling", [])[:3]
    for run in runs:
        x = run["position"]
        fit = ExponentialFit(run["p1"], run["p2"], run["p3"], 0.0)
        keep = (x >= 0.1) & np.isfinite(run["fx"])
        mark = run["settling_distance"]
        lines = [
            Series("measured", x, run["fx"], color=PALETTE[0]),
            Series("fitted", x[keep], fit(x[keep]), "model", INK),
        ]
        where = f"settles at {mark:.2f} m" if np.isfinite(mark) else "does not settle within 5 %"
        where = where if np.isfinite(run["reference"]) else "flexplates off: no controller"
        yield Figure(
            f"settling_{run['run']}",
            f"Free rolling, {run['run']}",
            f"Exponential function (E.1); {where} (dotted).",
            (
                Panel(
                    "road displacement [m]",
                    "longitudinal force Fx [N]",
                    lines,
                    marks=(mark,) if np.isfinite(mark) else (),
                ),
            ),
            "E.1, 5.20",
        )


@maker("machine")
def vertical(result: CampaignResult) -> Iterator[Figure]:
    """Figures G.5 and G.6."""
    runs = result.extras.get("vertical_stiffness", [])
    if not runs:
        return
    lines = [
        Series(f"{r['pressure']:g} bar", 1e3 * r["loaded_radius"], r["fz"], color=PALETTE[i % 6])
        for i, r in enumerate(runs)
    ]
    window = tuple(1e3 * v for v in runs[0]["window"])
    bars = np.array([r["pressure"] for r in runs])
    stiffness = np.array([1e-3 * r["mean"] for r in runs])
    over_pressure = Series("", bars, stiffness, "points")
    yield Figure(
        "vertical_stiffness",
        "Vertical stiffness",
        "Force over loaded radius; the fit uses what lies between the dotted lines, loading and "
        "unloading apart, and takes their mean.",
        (
            Panel("loaded radius [mm]", "vertical force Fz [N]", lines, marks=window),
            Panel("pressure [bar]", "stiffness Cz [kN/m]", [over_pressure]),
        ),
        "G.5, G.6",
    )


@maker("machine")
def contact_length(result: CampaignResult) -> Iterator[Figure]:
    """Figure G.4."""
    found = result.extras.get("footprints")
    if found is None:
        return
    series = []
    for bar in np.unique(found["pressure"]):
        mine = found["pressure"] == bar
        order = np.argsort(found["fz"][mine])
        x, y = found["fz"][mine][order], 1e3 * found["half_length"][mine][order]
        series.append(Series(f"{bar:g} bar", x, y, "joined"))
    panel = Panel("vertical force Fz [N]", "half contact length a [mm]", series)
    yield Figure("contact_length", "Contact length", "From footprints.", (panel,), "G.4")


@maker("machine")
def friction(result: CampaignResult) -> Iterator[Figure]:
    """Figure 5.3."""
    found = result.extras.get("friction_torque")
    if found is None:
        return
    line = Series("", found["speed"], found["torque"], "joined")
    panel = Panel("motor speed [rad/s]", "friction torque [N m]", (line,))
    caption = "Motor torque with the wheel hanging free."
    yield Figure("friction_torque", "Friction of the wheel drive", caption, (panel,), "5.3")
