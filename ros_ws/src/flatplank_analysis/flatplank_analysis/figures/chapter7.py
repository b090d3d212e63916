# SPDX-License-Identifier: Apache-2.0
"""Figures of chapter 7: models beside measurements, and their parameters."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from flatplank_analysis.figures import pieces
from flatplank_analysis.figures.registry import maker
from flatplank_analysis.figures.spec import Figure, Panel, Series
from flatplank_analysis.figures.style import INK, PALETTE
from flatplank_analysis.models.magic_formula import Coefficients, steady
from flatplank_analysis.report.results import CampaignResult, PointResult
from flatplank_data.condition import Condition

OVERLAYS = {"linear": "7.2, 7.5, 7.15", "nonlinear": "7.22, 7.23", "mf": "7.28"}


@maker("models")
def errors_beside_floor(result: CampaignResult) -> Iterator[Figure]:
    """Tables 7.1, 7.3, 7.4 as a picture: error of every model over slip, beside the floor."""
    point = result.nominal()
    if point is None or not point.models:
        return
    conditions = pieces.slips(point)
    kappa = np.array([100.0 * c.condition.kappa for c in conditions])
    lines = []
    for model in point.models.values():
        known = np.array([model.rmse.get(c.condition, np.nan) for c in conditions])
        lines.append(Series(model.title, kappa, known, "joined"))
    floor = np.array([c.floor() for c in conditions])
    if np.isfinite(floor).any():
        lines.append(Series("floor of the repeats", kappa, floor, "model", INK))
    panel = Panel("slip κ [%]", "RMSE in the transient part [N]", lines)
    caption = f"At {point.point.label()}. Below the floor no model can be judged."
    title = "Errors of the models beside the floor"
    yield Figure("models_floor", title, caption, (panel,), "7.1, 7.3, 7.4")


@maker("models")
def overlays(result: CampaignResult) -> Iterator[Figure]:
    """Measured and modelled force, at the nominal point and where one factor is varied."""
    for point in _overlaid(result):
        for name, model in point.models.items():
            conditions = [c for c in pieces.slips(point) if c.condition in model.curves]
            if not conditions:
                continue
            window = pieces.step_window(conditions)
            measured = pieces.force_lines(conditions, since_step=True)
            modelled = [
                Series("model", *model.curves[c.condition], "model", legend=i == 0)
                for i, c in enumerate(conditions)
            ]
            yield Figure(
                f"overlay_{name}_{_slug(point)}",
                f"{model.title[0].upper()}{model.title[1:]}, {point.point.label()}",
                "Coloured: measured, mean of the runs. Dashed: model.",
                (Panel(pieces.SINCE_STEP, pieces.FX, [*measured, *modelled], window),),
                OVERLAYS.get(name, ""),
            )


def _overlaid(result: CampaignResult) -> list[PointResult]:
    """The nominal point, then those that differ from it in one factor: what chapter 7 shows."""
    nominal = result.nominal()
    points = [] if nominal is None else [nominal]
    for factor in pieces.FACTORS:
        points += [p for p in pieces.varied(result, factor) if p is not nominal]
    return points


def _slug(point: PointResult) -> str:
    p = point.point
    return f"Fz{p.fz:g}_p{10 * p.pressure:g}_a{p.alpha_deg:g}_g{p.gamma_deg:g}"


@maker("parameters")
def linear_parameters(result: CampaignResult) -> Iterator[Figure]:
    """Figures 7.3, 7.8, 7.10, 7.12, 7.17: sigma_x and C'_Fk over slip, for what is varied."""
    point = result.nominal()
    if point is None:
        return
    title = "Parameters of the linear model"
    yield from _parameters([(point, point.point.label())], "linear_parameters", title, "7.3")
    for factor, (symbol, _) in pieces.FACTORS.items():
        points = pieces.varied(result, factor)
        if points:
            labelled = [(p, pieces.level(factor, getattr(p.point, factor))) for p in points]
            name = f"linear_parameters_{factor.removesuffix('_deg')}"
            yield from _parameters(
                labelled, name, f"Parameters for different {symbol}", "7.8 to 7.19"
            )


def _parameters(points, name: str, title: str, source: str) -> Iterator[Figure]:
    left, right = [], []
    for point, label in points:
        conditions = pieces.slips(point)
        kappa = [100.0 * c.condition.kappa for c in conditions]
        fits = [c.linear for c in conditions]
        left.append(pieces.estimate_points(label, kappa, [f.sigma for f in fits]))
        stiffness = pieces.estimate_points(label, kappa, [f.slip_stiffness for f in fits])
        right.append(pieces.scaled(stiffness, 1e-3))
    panels = [
        pieces.panel("slip κ [%]", "relaxation length σx [m]", left),
        pieces.panel("slip κ [%]", "local slip stiffness C′Fκ [kN]", right),
    ]
    caption = "One fit of (7.11) per slip level; bars are standard errors."
    yield from pieces.figure(name, title, caption, panels, source)


@maker("parameters")
def parameters_over_factor(result: CampaignResult) -> Iterator[Figure]:
    """Figures 7.9, 7.16: parameters at -1 and +1 % over load, pressure and angles."""
    for factor, (symbol, unit) in pieces.FACTORS.items():
        points = pieces.varied(result, factor)
        left, right = [], []
        for kappa in (-0.01, 0.01) if points else ():
            there = [(getattr(p.point, factor), pieces.at_slip(p, kappa)) for p in points]
            known = [(x, c) for x, c in there if c is not None]
            x = [value for value, _ in known]
            label = f"κ = {pieces.percent(kappa)}"
            left.append(pieces.estimate_points(label, x, [c.linear.sigma for _, c in known]))
            series = pieces.estimate_points(label, x, [c.linear.slip_stiffness for _, c in known])
            right.append(pieces.scaled(series, 1e-3))
        axis = f"{symbol} [{unit}]"
        panels = [
            pieces.panel(axis, "relaxation length σx [m]", left),
            pieces.panel(axis, "local slip stiffness C′Fκ [kN]", right),
        ]
        name = f"small_slip_over_{factor.removesuffix('_deg')}"
        title = f"Small slip over {symbol}"
        caption = "Linear model at the smallest slips; bars are standard errors."
        yield from pieces.figure(name, title, caption, panels, "7.9, 7.16")


@maker("parameters")
def steady_curves(result: CampaignResult) -> Iterator[Figure]:
    """Figures 7.7, 7.11, 7.13, 7.18: steady Fx over slip; 7.14: steady Fy over side slip."""
    point = result.nominal()
    if point is None:
        return
    shown: list[tuple[str, list[tuple[PointResult, str]]]] = [("", [(point, "")])]
    for factor in pieces.FACTORS:
        points = pieces.varied(result, factor)
        if points:
            labelled = [(p, pieces.level(factor, getattr(p.point, factor))) for p in points]
            shown.append((factor, labelled))
    for factor, members in shown:
        lines = [_steady(*member) for member in members]
        suffix = f"_{factor.removesuffix('_deg')}" if factor else ""
        title = "Steady force over slip"
        if factor:
            title += f" for different {pieces.FACTORS[factor][0]}"
        yield Figure(
            f"steady_fx{suffix}",
            title,
            "Asymptote of the linear model, fitted together with σx. Hollow: the run had not "
            "settled, so the asymptote is an extrapolation.",
            (Panel("actual slip κ [%]", "steady Fx [N]", [s for line in lines for s in line]),),
            "7.7, 7.11, 7.13, 7.18",
        )
    yield from _steady_lateral(result)


def _steady(point: PointResult, label: str) -> list[Series]:
    conditions = pieces.slips(point)
    x = np.array([100.0 * c.facts.kappa_actual for c in conditions])
    y = np.array([c.linear.steady_force.value for c in conditions])
    error = np.nan_to_num(np.array([c.linear.steady_force.std_error for c in conditions]))
    settled = np.array([c.linear.settled for c in conditions])
    out = [Series(label, x, y, "joined", error=error)]
    if not settled.all():
        out.append(Series("not settled", x[~settled], y[~settled], "hollow", INK))
    return out


def _steady_lateral(result: CampaignResult) -> Iterator[Figure]:
    points = pieces.varied(result, "alpha_deg")
    if not points:
        return
    lines = []
    for kappa in (-0.1, -0.05, 0.0, 0.05, 0.1):
        there = [(p.point.alpha_deg, pieces.at_slip(p, kappa)) for p in points]
        known = [(a, c.lateral_steady) for a, c in there if c is not None]
        if len(known) > 1:
            x, y = np.array(known).T
            lines.append(Series(f"κ = {pieces.percent(kappa)}", x, y, "joined"))
    if lines:
        caption = "Mean lateral force over the last half metre of road."
        panel = Panel("side slip angle α [°]", "steady Fy [N]", lines)
        yield Figure("steady_fy", "Steady lateral force", caption, (panel,), "7.14")


@maker("parameters")
def magic_curves(result: CampaignResult) -> Iterator[Figure]:
    """Figures 7.26, 7.27: steady forces, points measured, lines by the Magic Formula."""
    if result.magic is None:
        return
    coefficients = result.magic.tir.coefficients
    points = pieces.varied(result, "fz") or [p for p in [result.nominal()] if p is not None]
    series = []
    for point, color in zip(points, PALETTE, strict=False):
        conditions = pieces.slips(point)
        kappa = np.array([c.facts.kappa_actual for c in conditions])
        force = np.array([c.linear.steady_force.value for c in conditions])
        load = float(np.mean([c.facts.fz_after for c in conditions]))
        label = pieces.level("fz", point.point.fz)
        there = partial(_force, coefficients, load, point.point)
        reach = (100.0 * kappa.min(), 100.0 * kappa.max())
        series += pieces.with_model(label, color, (100.0 * kappa, force), reach, there)
    caption = "Points: asymptotes of the runs. Lines: the fitted Magic Formula at the mean load."
    panel = Panel("slip κ [%]", "steady Fx [N]", series)
    yield Figure("magic_formula_fx", "Magic Formula, Fx", caption, (panel,), "7.26")


def _force(c: Coefficients, fz: float, point: Condition, percent: np.ndarray) -> np.ndarray:
    angles = (point.alpha_deg, point.gamma_deg)
    return steady(c, pieces.at_point(c, fz, 0.01 * percent, *angles, point.pressure)).fx


@maker("parameters")
def carcass(result: CampaignResult) -> Iterator[Figure]:
    """Figures 7.24 and 7.25: c_cx and sigma_x by (7.27) over each factor."""
    for factor, (symbol, unit) in pieces.FACTORS.items():
        points = [p for p in pieces.varied(result, factor) if p.carcass is not None]
        if len(points) < 2:
            continue
        x = [getattr(p.point, factor) for p in points]
        stiffness = pieces.estimate_points("", x, [p.carcass.c_cx for p in points])
        sigma = pieces.estimate_points("", x, [p.carcass.sigma_x for p in points])
        panels = [
            pieces.panel(
                f"{symbol} [{unit}]",
                "carcass stiffness c_cx [kN/m]",
                [pieces.scaled(stiffness, 1e-3)],
            ),
            pieces.panel(f"{symbol} [{unit}]", "relaxation length σx by (7.27) [m]", [sigma]),
        ]
        name = f"carcass_over_{factor.removesuffix('_deg')}"
        caption = "Nonlinear model, one value per operating point; bars are standard errors."
        title = f"Carcass stiffness over {symbol}"
        yield from pieces.figure(name, title, caption, panels, "7.24, 7.25")
