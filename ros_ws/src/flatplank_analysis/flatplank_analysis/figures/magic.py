# SPDX-License-Identifier: Apache-2.0
"""The fitted Magic Formula with its data: Fx, Fy, rolling radius (figures 7.26 to 7.31)."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from flatplank_analysis.figures import pieces
from flatplank_analysis.figures.spec import PALETTE, Figure, Panel, Series
from flatplank_analysis.report.radii import radius_values
from flatplank_analysis.report.results import CampaignResult
from flatplank_data.condition import Condition
from flatplank_tire.magic_formula import Coefficients, steady
from flatplank_tire.magic_formula.structure import effective_radius

COEFFICIENTS = "Lines: the fitted coefficients."


def magic_curves(result: CampaignResult) -> Iterator[Figure]:
    """Figure 7.26: steady Fx over slip."""
    if result.magic is None:
        return
    fitted = result.magic.tir.coefficients
    series: list[Series] = []
    for point, color in zip(pieces.loads(result), PALETTE, strict=False):
        conditions = pieces.slips(point)
        slip = 100.0 * np.array([c.facts.kappa_actual for c in conditions])
        force = np.array([c.linear.steady_force.value for c in conditions])
        error = np.array([c.linear.steady_force.std_error for c in conditions])
        load = float(np.mean([c.facts.fz_after for c in conditions]))

        def there(percent: np.ndarray, load: float = load, p: Condition = point.point):
            angles = (p.alpha_deg, p.gamma_deg)
            at = pieces.at_point(fitted, load, 0.01 * percent, *angles, p.pressure)
            return steady(fitted, at).fx

        label, reach = pieces.level(point, "fz"), (slip.min(), slip.max())
        bars = np.nan_to_num(error)
        series += pieces.with_model(label, color, (slip, force), reach, there, bars)
    caption = (
        "Points: asymptotes of the runs with their standard errors. Lines: the fitted Magic "
        "Formula at the mean load."
    )
    panel = Panel(pieces.SLIP, "steady Fx [N]", series)
    yield Figure("magic_formula_fx", "Magic Formula, Fx", caption, (panel,), "7.26")


def magic_lateral(result: CampaignResult) -> Iterator[Figure]:
    """Figure 7.27: steady Fy over side slip."""
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
    series: list[Series] = []
    shown = {k: v for k, v in sorted(groups.items()) if len(v) > 1}
    for (fz, bar, gamma), color in zip(shown, PALETTE, strict=False):
        alpha, force, load = np.array(sorted(shown[fz, bar, gamma])).T

        def there(x: np.ndarray, fz: float = float(load.mean()), at: tuple = (gamma, bar)):
            return steady(c, pieces.at_point(c, fz, 0.0, x, *at)).fy

        label = f"{fz:g} N, {bar:g} bar, γ {gamma:g}°"
        reach = (alpha.min(), alpha.max())
        series += pieces.with_model(label, color, (alpha, force), reach, there)
    caption = f"Points: mean of the last half metre at 0 % slip. {COEFFICIENTS}"
    panels = [pieces.panel(pieces.ALPHA, "steady Fy [N]", series)]
    yield from pieces.figure("magic_formula_fy", "Magic Formula, Fy", caption, panels, "7.27")


def modelled_radius(result: CampaignResult) -> Iterator[Figure]:
    """Figure 7.30: r_e over load per pressure."""
    if result.magic is None or "re" not in result.magic.fits:
        return
    c = result.magic.tir.coefficients
    groups: dict[float, list[tuple[float, float]]] = {}
    for v in radius_values(result):
        if not v.point.alpha_deg and not v.point.gamma_deg:
            here = (v.point.fz, 1e3 * v.corrected.value)
            groups.setdefault(v.point.pressure, []).append(here)
    series: list[Series] = []
    for bar, color in zip(sorted(groups), PALETTE, strict=False):
        x, y = np.array(groups[bar]).T
        there = partial(_radius_mm, c, 0.0, 0.0, bar)
        reach = (0.7 * x.min(), 1.2 * x.max())
        series += pieces.with_model(f"{bar:g} bar", color, (x, y), reach, there)
    caption = f"Points: measured, at Fx = 0. {COEFFICIENTS}"
    title = "Rolling radius, measured and modelled"
    panels = [pieces.panel(pieces.FZ, pieces.RADIUS, series)]
    yield from pieces.figure("rolling_radius_model", title, caption, panels, "7.30")


def modelled_radius_angles(result: CampaignResult) -> Iterator[Figure]:
    """Figures 7.30, 7.31: r_e over side slip per camber."""
    nominal = result.nominal()
    if nominal is None or result.magic is None or "re" not in result.magic.fits:
        return
    c, (fz, bar) = result.magic.tir.coefficients, (nominal.point.fz, nominal.point.pressure)
    groups: dict[float, list[tuple[float, float]]] = {}
    for v in radius_values(result):
        if (v.point.fz, v.point.pressure) == (fz, bar):
            here = (v.point.alpha_deg, 1e3 * v.corrected.value)
            groups.setdefault(v.point.gamma_deg, []).append(here)
    series: list[Series] = []
    for gamma, color in zip(sorted(groups), PALETTE, strict=False):
        x, y = np.array(sorted(groups[gamma])).T
        if np.ptp(x) == 0.0:
            continue

        def there(alpha: np.ndarray, gamma: float = gamma) -> np.ndarray:
            return _radius_mm(c, alpha, gamma, bar, fz)

        series += pieces.with_model(f"γ = {gamma:g}°", color, (x, y), (x.min(), x.max()), there)
    caption = f"Points: measured, at Fx = 0, all sources. {COEFFICIENTS}"
    title = "Rolling radius over side slip, measured and modelled"
    panels = [pieces.panel(pieces.ALPHA, pieces.RADIUS, series)]
    yield from pieces.figure("rolling_radius_angles", title, caption, panels, "7.30, 7.31")


def _radius_mm(c: Coefficients, alpha: Any, gamma: float, bar: float, fz: Any) -> np.ndarray:
    return 1e3 * effective_radius(c, pieces.at_point(c, fz, 0.0, alpha, gamma, bar), 0.0)
