# SPDX-License-Identifier: Apache-2.0
"""Wheel drive (5.4, 5.13), lateral transients and the lateral Magic Formula (7.27)."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial

import numpy as np

from flatplank_analysis.figures import pieces
from flatplank_analysis.figures.registry import maker
from flatplank_analysis.figures.spec import Figure, Panel, Series
from flatplank_analysis.figures.style import PALETTE
from flatplank_analysis.models.magic_formula import Coefficients, steady
from flatplank_analysis.models.magic_formula.structure import effective_radius
from flatplank_analysis.report.machine_tables import friction_of
from flatplank_analysis.report.radii import radius_values
from flatplank_analysis.report.results import CampaignResult, PointResult


@maker("machine")
def transmission(result: CampaignResult) -> Iterator[Figure]:
    """Motor torque over slip and load; efficiency where the friction is known."""
    points = pieces.varied(result, "fz") or [p for p in [result.nominal()] if p is not None]
    curve = friction_of(result)
    torque, efficiency = [], []
    for point in points:
        label = pieces.level("fz", point.point.fz)
        torque.append(_over_slip(point, label, lambda s: s.motor_torque))
        if curve is not None:
            efficiency.append(_over_slip(point, label, lambda s: 100.0 * s.efficiency(curve)))
    panels = [
        pieces.panel("slip κ [%]", "motor torque M_M [N m]", torque),
        pieces.panel("slip κ [%]", "efficiency η [%]", efficiency),
    ]
    caption = (
        "Mean over the last half metre of each run. Efficiency (5.3) of driving runs, with the "
        "friction of unloaded turns."
    )
    title = "Torque of the wheel drive"
    yield from pieces.figure("transmission", title, caption, panels, "5.4, 5.13")


def _over_slip(point: PointResult, label: str, read) -> Series | None:
    groups: dict[float, list[float]] = {}
    for run in point.beside.drive:
        value = read(run.state)
        if math.isfinite(value):
            groups.setdefault(run.condition.kappa, []).append(value)
    if not groups:
        return None
    x = np.array(sorted(groups))
    y = np.array([np.mean(groups[k]) for k in x])
    return Series(label, 100.0 * x, y, "joined")


@maker("parameters")
def lateral_starts(result: CampaignResult) -> Iterator[Figure]:
    """Fy from the start of rolling, and its relaxation length over the slip angle."""
    points = [p for p in result.points if p.beside.lateral is not None]
    nominal = result.nominal()
    near = [p for p in pieces.varied(result, "alpha_deg") if p in points]
    if not near and points and nominal is not None:
        near = points[:4]
    if not near:
        return
    lines = []
    for point, color in zip(near, PALETTE, strict=False):
        found = point.beside.lateral
        label = pieces.level("alpha_deg", point.point.alpha_deg)
        lines.append(Series(label, found.distance, found.force, color=color))
        model = -found.fit.response(found.distance)
        lines.append(Series("model", found.distance, model, "model", legend=point is near[0]))
    x = [p.point.alpha_deg for p in near]
    sigma = pieces.estimate_points("", x, [p.beside.lateral.fit.sigma for p in near])
    panels = [
        Panel("road displacement since the start [m]", pieces.FY, lines),
        pieces.panel("side slip angle α [°]", "relaxation length σy [m]", [sigma]),
    ]
    caption = "Mean of all runs of an operating point up to the slip step; dashed: first order."
    yield from pieces.figure("lateral_start", "Lateral transient", caption, panels)


@maker("parameters")
def magic_lateral(result: CampaignResult) -> Iterator[Figure]:
    """Figure 7.27: steady Fy over side slip, points measured, lines by the Magic Formula."""
    if result.magic is None or "fy" not in result.magic.fits:
        return
    c = result.magic.tir.coefficients
    groups: dict[tuple[float, float, float], list[tuple[float, float, float]]] = {}
    for point in result.points:
        free = pieces.at_slip(point, 0.0)
        if free is None or not math.isfinite(free.lateral_steady):
            continue
        key = (point.point.fz, point.point.pressure, point.point.gamma_deg)
        load = free.facts.fz_after if math.isfinite(free.facts.fz_after) else point.point.fz
        groups.setdefault(key, []).append((point.point.alpha_deg, free.lateral_steady, load))
    series = []
    shown = {k: v for k, v in sorted(groups.items()) if len(v) > 1}
    for (fz, bar, gamma), color in zip(shown, PALETTE, strict=False):
        alpha, force, load = np.array(sorted(shown[fz, bar, gamma])).T
        label = f"{fz:g} N, {bar:g} bar, γ {gamma:g}°"
        there = partial(_side_force, c, float(load.mean()), gamma, bar)
        series += pieces.with_model(
            label, color, (alpha, force), (alpha.min(), alpha.max()), there
        )
    if series:
        caption = "Points: mean of the last half metre at κ = 0. Lines: the fitted coefficients."
        panel = Panel("side slip angle α [°]", "steady Fy [N]", series)
        yield Figure("magic_formula_fy", "Magic Formula, Fy", caption, (panel,), "7.27")


def _side_force(
    c: Coefficients, fz: float, gamma: float, bar: float, alpha: np.ndarray
) -> np.ndarray:
    return steady(c, pieces.at_point(c, fz, 0.0, alpha, gamma, bar)).fy


def _radius_mm(
    c: Coefficients, fz: float, gamma: float, bar: float, alpha: np.ndarray
) -> np.ndarray:
    return 1e3 * effective_radius(c, pieces.at_point(c, fz, 0.0, alpha, gamma, bar), 0.0)


@maker("radius")
def modelled_radius_angles(result: CampaignResult) -> Iterator[Figure]:
    """Figures 7.30, 7.31: r_e over side slip per camber, measured and modelled."""
    nominal = result.nominal()
    if nominal is None or result.magic is None or "re" not in result.magic.fits:
        return
    c, base = result.magic.tir.coefficients, nominal.point
    values = [
        v
        for v in radius_values(result)
        if (v.point.fz, v.point.pressure) == (base.fz, base.pressure)
    ]
    series = []
    for gamma, color in zip(sorted({v.point.gamma_deg for v in values}), PALETTE, strict=False):
        mine = sorted(
            (v.point.alpha_deg, 1e3 * v.corrected.value)
            for v in values
            if v.point.gamma_deg == gamma
        )
        x, y = np.array(mine).T
        if np.ptp(x) == 0.0:
            continue
        there = partial(_radius_mm, c, base.fz, gamma, base.pressure)
        label = f"γ = {gamma:g}°"
        series += pieces.with_model(label, color, (x, y), (x.min(), x.max()), there)
    if series:
        caption = "Points: measured, at Fx = 0, all sources. Lines: the fitted coefficients."
        panel = Panel("side slip angle α [°]", "effective rolling radius [mm]", series)
        title = "Rolling radius over side slip, measured and modelled"
        yield Figure("rolling_radius_angles", title, caption, (panel,), "7.30, 7.31")
