# SPDX-License-Identifier: Apache-2.0
"""Figures of chapter 7: models compared with measurements, and their parameters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from flatplank_analysis.discovery.floor import BELOW
from flatplank_analysis.figures import pieces
from flatplank_analysis.figures.spec import INK, PALETTE, Figure, Panel, Series
from flatplank_analysis.identify.linear import LinearFit
from flatplank_analysis.report.results import (
    CampaignResult,
    ConditionResult,
    ModelCurves,
    PointResult,
)

OVERLAYS = {"linear": "7.2, 7.5, 7.15", "nonlinear": "7.22, 7.23", "mf_contact_point": "7.28"}
LINEAR = (
    ("relaxation length σx [m]", "sigma", 1.0),
    ("local slip stiffness C′Fκ [kN]", "slip_stiffness", 1e-3),
)
CARCASS = (
    ("carcass stiffness c_cx [kN/m]", "c_cx", 1e-3),
    ("relaxation length σx by (7.27) [m]", "sigma_x", 1.0),
)
"""label of the axis, attribute of the fit, factor from SI (both tables)"""


def errors_beside_floor(result: CampaignResult) -> Iterator[Figure]:
    """Tables 7.1, 7.3, 7.4 as a figure: error of every model over slip, with the floor."""
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
        lines.append(Series("floor of the mean", kappa, floor, "model", INK))
    panel = Panel(pieces.SLIP, "RMSE in the transient part [N]", lines)
    caption = f"At {point.point.label()}; {BELOW}."
    title = "Errors of the models beside the floor"
    yield Figure("models_floor", title, caption, (panel,), "7.1, 7.3, 7.4")


def overlays(result: CampaignResult) -> Iterator[Figure]:
    """Measured and modelled force, at the nominal point and where one factor is varied."""
    nominal = result.nominal()
    points = [] if nominal is None else [nominal]
    for varied in pieces.variations(result):
        points += [p for p in varied.points if p is not nominal]
    for point in points:
        p = point.point
        slug = f"Fz{p.fz:g}_p{10 * p.pressure:g}_a{p.alpha_deg:g}_g{p.gamma_deg:g}"
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
            panel = Panel(pieces.SINCE_STEP, pieces.FX, [*measured, *modelled], window)
            yield Figure(
                f"overlay_{name}_{slug}",
                f"{model.title[0].upper()}{model.title[1:]}, {p.label()}",
                "Coloured: measured, mean of the runs. Dashed: model. Below: measured less "
                "modelled force, in the same colours.",
                (pieces.with_residual(panel, _left(conditions, model)),),
                OVERLAYS.get(name, ""),
            )


def _left(conditions: Sequence[ConditionResult], model: ModelCurves) -> list[Series]:
    """Measured less modelled force of every slip level."""
    tone = pieces.slip_colors(conditions)
    return [
        pieces.residual(
            c.since_step, c.measured["fx"], *model.curves[c.condition], tone[c.condition.kappa]
        )
        for c in conditions
    ]


def lateral_starts(result: CampaignResult) -> Iterator[Figure]:
    """Fy from the start of rolling, and its relaxation length over the slip angle."""
    points = [p for p in result.points if p.further.lateral is not None]
    near = [
        p for v in pieces.variations(result, "alpha_deg") for p in v.points if p in points
    ] or (points[:4] if result.nominal() is not None else [])
    if not near:
        return
    lines, left = [], []
    for point, color in zip(near, PALETTE, strict=False):
        found = point.further.lateral
        assert found is not None, "one of the points"
        label = pieces.level(point, "alpha_deg")
        x, model = found.distance, -found.fit.response(found.distance)
        lines.append(Series(label, x, found.force, color=color))
        lines.append(Series("model", x, model, "model", legend=point is near[0]))
        left.append(pieces.residual(x, found.force, x, model, color))
    fits = [
        (p.point.alpha_deg, start.fit) for p in near if (start := p.further.lateral) is not None
    ]
    panels = [
        pieces.with_residual(
            Panel("road displacement since the start [m]", pieces.FY, lines), left
        ),
        *pieces.estimates(
            pieces.ALPHA, [("", fits)], [("relaxation length σy [m]", "sigma", 1.0)]
        ),
    ]
    caption = "Mean of all runs of an operating point up to the slip step; dashed: first order."
    yield from pieces.figure("lateral_start", "Lateral transient", caption, panels)


def linear_parameters(result: CampaignResult) -> Iterator[Figure]:
    """Figures 7.3, 7.8, 7.10, 7.12, 7.17: sigma_x and C'_Fk over slip, for varied factors."""
    point = result.nominal()
    if point is None:
        return
    shown = [([(point, point.point.label())], "", "Parameters of the linear model", "7.3")]
    for v in pieces.variations(result):
        title = f"Parameters for different {v.symbol}"
        shown.append((v.labelled, f"_{v.name}", title, "7.8 to 7.19"))
    caption = "One fit of (7.11) per slip level; bars are standard errors."
    for points, suffix, title, source in shown:
        groups = [
            (label, [(100.0 * c.condition.kappa, c.linear) for c in pieces.slips(p)])
            for p, label in points
        ]
        panels = pieces.estimates(pieces.SLIP, groups, LINEAR)
        yield from pieces.figure(f"linear_parameters{suffix}", title, caption, panels, source)


def crossed_angles(result: CampaignResult) -> Iterator[Figure]:
    """Figures 7.19 and 7.20: side slip crossed with camber, parameters and steady force."""
    groups: list[tuple[str, list[tuple[float, LinearFit]]]] = []
    steady: list[Series] = []
    looks: dict[str, Look] = {}
    for gamma, points in pieces.crossed(result).items():
        for point, color in zip(points, PALETTE, strict=False):
            label = f"α = {point.point.alpha_deg:g}°, γ = {gamma:g}°"
            looks[label] = Look(point.point.alpha_deg, gamma, color)
            fits = [(100.0 * c.condition.kappa, c.linear) for c in pieces.slips(point)]
            groups.append((label, fits))
            steady.append(_steady(point, label)[0])
    if not groups:
        return
    panels = [
        panel and replace(panel, series=_by_camber(panel.series, looks))
        for panel in pieces.estimates(pieces.SLIP, groups, LINEAR)
    ]
    caption = "One fit of (7.11) per slip level. Filled: without camber; open: with it."
    title = "Parameters of the linear model, side slip and camber"
    yield from pieces.figure("linear_parameters_crossed", title, caption, panels, "7.19")
    panel = Panel("actual slip κ [%]", "steady Fx [N]", _by_camber(steady, looks))
    title = "Steady force over slip, side slip and camber"
    caption = "Asymptotes of the linear model. Filled: without camber; open: with it."
    yield Figure("steady_fx_crossed", title, caption, (panel,), "7.20")


class Look(NamedTuple):
    """Angles of a line [deg] and its colour."""

    alpha: float
    gamma: float
    color: str


def _by_camber(lines: Sequence[Series], looks: Mapping[str, Look]) -> list[Series]:
    """Filled marks without camber, open ones with it; the side slip stands at the end of a line,
    the camber in the legend."""
    none = np.zeros(0)
    out = [
        Series(f"γ = {gamma:g}°", none, none, "open" if gamma else "joined", INK)
        for gamma in dict.fromkeys(look.gamma for look in looks.values())
    ]
    for line in lines:
        look = looks[line.label]
        style = "open" if look.gamma else "joined"
        shown = replace(line, label=f"α = {look.alpha:g}°", style=style, color=look.color)
        out.append(replace(shown, error=None, legend=False, end_label=not look.gamma))
    return out


def parameters_over_factor(result: CampaignResult) -> Iterator[Figure]:
    """Figures 7.9, 7.16: parameters at -1 and +1 % over load, pressure and angles."""
    for v in pieces.variations(result):
        groups = [
            (f"κ = {pieces.percent(kappa)}", [(x, c.linear) for x, c in v.at_slip(kappa)])
            for kappa in (-0.01, 0.01)
        ]
        panels = pieces.estimates(v.axis, groups, LINEAR)
        caption = "Linear model at the smallest slips; bars are standard errors."
        name, title = f"small_slip_over_{v.name}", f"Small slip over {v.symbol}"
        yield from pieces.figure(name, title, caption, panels, "7.9, 7.16")


def carcass(result: CampaignResult) -> Iterator[Figure]:
    """Figures 7.24 and 7.25: c_cx and sigma_x by (7.27) over each factor."""
    for v in pieces.variations(result):
        fits = [(getattr(p.point, v.factor), p.carcass) for p in v.points if p.carcass is not None]
        if len(fits) < 2:
            continue
        panels = pieces.estimates(v.axis, [("", fits)], CARCASS)
        caption = "Nonlinear model, one value per operating point; bars are standard errors."
        name, title = f"carcass_over_{v.name}", f"Carcass stiffness over {v.symbol}"
        yield from pieces.figure(name, title, caption, panels, "7.24, 7.25")


def steady_curves(result: CampaignResult) -> Iterator[Figure]:
    """Figures 7.7, 7.11, 7.13, 7.18: steady Fx over slip; 7.14: steady Fy over side slip."""
    point = result.nominal()
    if point is None:
        return
    shown = [([(point, "")], "", "Steady force over slip")]
    for v in pieces.variations(result):
        title = f"Steady force over slip for different {v.symbol}"
        shown.append((v.labelled, f"_{v.name}", title))
    for members, suffix, title in shown:
        lines = [s for member in members for s in _steady(*member)]
        yield Figure(
            f"steady_fx{suffix}",
            title,
            "Asymptote of the linear model, fitted together with σx. Hollow: the run had not "
            "settled, so the asymptote is an extrapolation.",
            (Panel("actual slip κ [%]", "steady Fx [N]", lines),),
            "7.7, 7.11, 7.13, 7.18",
        )
    for v in pieces.variations(result, "alpha_deg"):
        yield from _steady_lateral(v)


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


def _steady_lateral(varied: pieces.Variation) -> Iterator[Figure]:
    lines = []
    for kappa in (-0.1, -0.05, 0.0, 0.05, 0.1):
        known = [(a, c.lateral_steady) for a, c in varied.at_slip(kappa)]
        if len(known) > 1:
            x, y = np.array(known).T
            lines.append(Series(f"κ = {pieces.percent(kappa)}", x, y, "joined"))
    panels = [pieces.panel(pieces.ALPHA, "steady Fy [N]", lines)]
    caption = "Mean lateral force over the last half metre of road."
    yield from pieces.figure("steady_fy", "Steady lateral force", caption, panels, "7.14")
