# SPDX-License-Identifier: Apache-2.0
"""Figures of the wheel drive (5.3, 5.4, 5.13), r_e (6.1, 6.2), settling (E.1), and the standing
tire (Appendix G)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from flatplank_analysis.figures import pieces
from flatplank_analysis.figures.spec import INK, PALETTE, Figure, Panel, Series
from flatplank_analysis.report.machine_tables import DriveMeans, drive_means, friction_of
from flatplank_analysis.report.radii import radius_values
from flatplank_analysis.report.results import CampaignResult
from flatplank_analysis.steady.settling import FIT_RANGE


def transmission(result: CampaignResult) -> Iterator[Figure]:
    """Motor torque over slip and load; efficiency where the friction is known."""
    curve = friction_of(result)
    torque, efficiency = [], []
    for point in pieces.loads(result):
        label = pieces.level(point, "fz")
        means = drive_means(point, curve)
        torque.append(_over_slip(means, label, lambda m: m.state.motor_torque))
        efficiency.append(_over_slip(means, label, lambda m: 100.0 * m.efficiency.value))
    panels = [
        pieces.panel(pieces.SLIP, "motor torque M_M [N m]", torque),
        pieces.panel(pieces.SLIP, "efficiency η [%]", efficiency),
    ]
    caption = (
        "Mean over the last half metre and the start angles. Efficiency (5.3) of driving runs, "
        "with the friction of unloaded turns."
    )
    title = "Torque of the wheel drive"
    yield from pieces.figure("transmission", title, caption, panels, "5.4, 5.13")


def _over_slip(means: Sequence[DriveMeans], label: str, read) -> Series | None:
    known = [(100.0 * m.condition.kappa, read(m)) for m in means if math.isfinite(read(m))]
    if not known:
        return None
    slip, values = np.array(known).T
    return Series(label, slip, values, "joined")


def rolling_radius(result: CampaignResult) -> Iterator[Figure]:
    """r_e over load per pressure and source, and over side slip per camber."""
    values = radius_values(result)
    straight = [v for v in values if not v.point.alpha_deg and not v.point.gamma_deg]
    panels = []
    if len({v.point.fz for v in straight}) > 1:
        panels.append(_lines(straight, "fz", "pressure", pieces.FZ, "{:g} bar"))
    nominal = result.nominal()
    here = (nominal.point.fz, nominal.point.pressure) if nominal else None
    turned = [v for v in values if (v.point.fz, v.point.pressure) == here]
    if len({v.point.alpha_deg for v in turned}) > 1:
        panels.append(_lines(turned, "alpha_deg", "gamma_deg", pieces.ALPHA, "γ {:g}°"))
    caption = "By (5.22), mean over the start angles, corrected to Fx = 0 with C_Fκ."
    if len(panels) > 1:
        caption += (
            " Over side slip: 50 N make a slip of 50 N / C_Fκ(α), which grows with α; an error "
            "δ of the steering angle a part of δ tan α. The thesis has a rise up to 5° (figure "
            "6.2), which neither explains."
        )
    title = "Effective rolling radius"
    yield from pieces.figure("rolling_radius", title, caption, panels, "6.1, 6.2")


def _lines(values, over: str, split: str, x_label: str, label: str) -> Panel:
    """A line per level of `split` and source."""
    series = []
    groups: dict[tuple, list] = {}
    for v in sorted(values, key=lambda v: getattr(v.point, over)):
        here = (getattr(v.point, over), 1e3 * v.corrected.value, 1e3 * v.corrected.std_error)
        groups.setdefault((getattr(v.point, split), v.source), []).append(here)
    for (level, source), members in sorted(groups.items()):
        x, y, error = np.array(members).T
        error = np.nan_to_num(error)
        text = f"{label.format(level)}, {source.replace('_', ' ')}"
        series.append(Series(text, x, y, "joined", error=error))
    return Panel(x_label, pieces.RADIUS, series)


def settling(result: CampaignResult) -> Iterator[Figure]:
    """Free-rolling runs with the exponential of Appendix E."""
    for run in result.extras.get("free_rolling", [])[:3]:
        x = run["position"]
        fit = run["fit"]
        keep = (x >= FIT_RANGE[0]) & np.isfinite(run["fx"])
        mark = run["settling_distance"]
        marks = (mark,) if np.isfinite(mark) else ()
        panel = Panel(
            pieces.ROAD, pieces.FX, [Series("measured", x, run["fx"], color=PALETTE[0])],
            marks=marks,
        )  # fmt: skip
        where = f"settles at {mark:.2f} m" if np.isfinite(mark) else "does not settle within 5 %"
        if fit is None:
            where = "not fitted, flexplates off: no controller"
        else:
            fitted = Series("fitted", x[keep], fit(x[keep]), "model", INK)
            left = pieces.residual(x, run["fx"], fitted.x, fitted.y, PALETTE[0])
            panel = replace(panel, series=[*panel.series, fitted])
            panel = pieces.with_residual(panel, [left])
            where += f"; {fit.remark}" * bool(fit.remark)
        yield Figure(
            f"settling_{run['run']}",
            f"Free rolling, {run['run']}",
            f"Exponential function (E.1); {where} (dotted).",
            (panel,),
            "E.1, 5.20",
        )


def vertical(result: CampaignResult) -> Iterator[Figure]:
    """Figures G.5 and G.6: Fz over loaded radius, vertical stiffness over pressure."""
    runs = result.extras.get("vertical_stiffness", [])
    if not runs:
        return
    lines = [
        Series(f"{r['pressure']:g} bar", 1e3 * r["loaded_radius"], r["fz"], color=PALETTE[i % 6])
        for i, r in enumerate(runs)
    ]
    window = tuple(1e3 * v for v in runs[0]["window"])
    bars = np.array([r["pressure"] for r in runs])
    over_pressure = Series("", bars, np.array([1e-3 * r["mean"] for r in runs]), "points")
    yield Figure(
        "vertical_stiffness",
        "Vertical stiffness",
        "Force over loaded radius; the fit uses what lies between the dotted lines, loading and "
        "unloading apart, and takes their mean.",
        (
            Panel("loaded radius [mm]", pieces.FZ, lines, marks=window),
            Panel("pressure [bar]", "stiffness Cz [kN/m]", [over_pressure]),
        ),
        "G.5, G.6",
    )


def contact_length(result: CampaignResult) -> Iterator[Figure]:
    """Figure G.4: half contact length over load."""
    found = result.extras.get("footprints")
    if found is None:
        return
    series = []
    for bar in np.unique(found["pressure"]):
        mine = found["pressure"] == bar
        order = np.argsort(found["fz"][mine])
        x, y = found["fz"][mine][order], 1e3 * found["half_length"][mine][order]
        series.append(Series(f"{bar:g} bar", x, y, "joined"))
    panel = Panel(pieces.FZ, "half contact length a [mm]", series)
    yield Figure("contact_length", "Contact length", "From footprints.", (panel,), "G.4")


def friction(result: CampaignResult) -> Iterator[Figure]:
    """Figure 5.3: friction torque over motor speed."""
    found = friction_of(result)
    if found is None:
        return
    line = Series("", found.speed, found.torque, "joined")
    panel = Panel("motor speed [rad/s]", "friction torque [N m]", (line,))
    caption = "Motor torque with the wheel hanging free."
    yield Figure("friction_torque", "Friction of the wheel drive", caption, (panel,), "5.3")
