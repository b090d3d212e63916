# SPDX-License-Identifier: Apache-2.0
"""Figures of chapter 7: those of a report under the number of the thesis, and those that compare
the machine before and after its repair."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from flatplank_analysis.figures import chapter7, magic, pieces
from flatplank_analysis.figures.spec import INK, PALETTE, Figure, Panel, Series
from flatplank_analysis.report.results import CampaignResult, ConditionResult
from flatplank_tire.magic_formula import steady
from flatplank_validation.thesis.errors import MAGIC
from flatplank_validation.thesis.lab import Lab
from flatplank_validation.thesis.points import point

AROUND = (-0.1, 0.3)
"""road around the step in figure 7.29 [m]"""
BEFORE, AFTER = "play 1.15 mm", "play 0.05 mm"
Make = Callable[[CampaignResult], Iterable[Figure]]


def whole(lab: Lab) -> CampaignResult:
    return lab.matrix


def repaired(lab: Lab) -> CampaignResult:
    return lab.repaired


def named(
    make: Make, name: str, lab: Lab, of: Callable[[Lab], CampaignResult] = whole
) -> Iterator[Figure]:
    """The figures of a maker of the report whose names begin so."""
    yield from (f for f in make(of(lab)) if f.name == name)


def overlay(
    model: str, of: Callable[[Lab], CampaignResult] = whole, **where: float
) -> Callable[[Lab], Iterator[Figure]]:
    """Measured and modelled forces of an operating point."""

    def draw(lab: Lab) -> Iterator[Figure]:
        p = point(of(lab), **where).point
        slug = f"Fz{p.fz:g}_p{10 * p.pressure:g}_a{p.alpha_deg:g}_g{p.gamma_deg:g}"
        yield from named(chapter7.overlays, f"overlay_{model}_{slug}", lab, of)

    return draw


def growth(lab: Lab) -> Iterator[Figure]:
    """Figure 7.4: forces before and after the repair, shifted to begin at 0."""
    lines: list[Series] = []
    there: list[ConditionResult] = []
    for word, result, style in ((BEFORE, lab.matrix, "line"), (AFTER, lab.repaired, "dashed")):
        conditions = [c for c in pieces.slips(point(result)) if c.condition.kappa]
        there += conditions
        tone = pieces.slip_colors(conditions)
        for k, c in enumerate(conditions):
            x, force = c.since_step, c.measured["fx"]
            start = float(np.mean(force[(x >= -0.1) & (x < 0.0)]))
            color = tone[c.condition.kappa]
            lines.append(
                Series(pieces.percent(c.condition.kappa), x, force - start, style, color,
                       end_label=style == "line", legend=False)
            )  # fmt: skip
            if k == 0:
                lines.append(Series(word, x[:0], force[:0], style, INK))
    panel = Panel(pieces.SINCE_STEP, "Fx less its value at the step [N]", lines,
                  pieces.step_window(there))  # fmt: skip
    caption = f"Full: {BEFORE}, dashed: {AFTER}."
    yield Figure("play_growth", "Before and after the repair of the road", caption, (panel,))


def repaired_parameters(lab: Lab) -> Iterator[Figure]:
    """Figure 7.6."""
    groups = [
        (word, [(100.0 * c.condition.kappa, c.linear) for c in pieces.slips(point(result))])
        for word, result in ((BEFORE, lab.matrix), (AFTER, lab.repaired))
    ]
    panels = pieces.estimates(pieces.SLIP, groups, chapter7.LINEAR)
    caption = "One fit of (7.11) per slip level; bars are standard errors."
    title = "Linear parameters before and after the repair"
    yield from pieces.figure("play_parameters", title, caption, panels)


def carcass(attribute: str, lab: Lab) -> Iterator[Figure]:
    """Figures 7.24 and 7.25: one quantity of the carcass fits over every factor."""
    label, _, factor = next(q for q in chapter7.CARCASS if q[1] == attribute)
    caption = "One fit per operating point; bars are standard errors."
    title = label.split(" [")[0]
    title = title[0].upper() + title[1:]
    for name, factors in (("", ("fz", "pressure")), ("_angles", ("alpha_deg", "gamma_deg"))):
        panels = _carcass_panels(attribute, label, factor, lab, factors)
        yield from pieces.figure(f"{attribute}{name}", title, caption, panels)


def _carcass_panels(
    attribute: str, label: str, factor: float, lab: Lab, factors: Sequence[str]
) -> list[Panel | None]:
    panels: list[Panel | None] = []
    for v in pieces.variations(lab.matrix, *factors):
        groups = [("γ = 0°" if v.factor == "alpha_deg" else "", _fits(v.points, v.factor))]
        if v.factor == "alpha_deg":
            for gamma, points in pieces.crossed(lab.matrix).items():
                if gamma:
                    groups.append((f"γ = {gamma:g}°", _fits(points, v.factor)))
        panels += pieces.estimates(v.axis, groups, [(label, attribute, factor)])
    return panels


def _fits(points, factor: str):
    return [(getattr(p.point, factor), p.carcass) for p in points if p.carcass is not None]


def around_the_step(lab: Lab) -> Iterator[Figure]:
    """Figure 7.29: measured and modelled force around the step."""
    nominal = point(lab.matrix)
    magic_fit, curves = lab.matrix.magic, nominal.models.get(MAGIC)
    if magic_fit is None or curves is None:
        return
    conditions = pieces.slips(nominal)
    lines = pieces.force_lines(conditions, since_step=True)
    for k, c in enumerate(conditions):
        x, force = curves.curves[c.condition]
        p = c.condition
        at = pieces.at_point(
            magic_fit.tir.coefficients, c.facts.fz_before, c.facts.kappa_before, 0.0, 0.0,
            p.pressure,
        )  # fmt: skip
        free = float(steady(magic_fit.tir.coefficients, at).fx)
        x, force = np.append([AROUND[0], 0.0], x), np.append([free, free], force)
        lines.append(Series("model", x, force, "model", INK, legend=k == 0))
    panel = Panel(pieces.SINCE_STEP, pieces.FX, lines, AROUND, (0.0,))
    caption = "Before the step: the model's steady force at the measured slip of the rolling tire."
    yield Figure("magic_zoom", "MF-Tyre around the step", caption, (panel,))


def modelled_radius(gamma: float, lab: Lab) -> Iterator[Figure]:
    """Figures 7.30 (without) and 7.31 (with camber)."""
    for f in magic.modelled_radius_angles(lab.matrix):
        lines: list[Series] = []
        shown = False
        for s in f.panels[0].series:
            shown = s.label == f"γ = {gamma:g}°"
            if not shown:
                continue
            word = "measured" if s.style == "points" else "model"
            color = PALETTE[0] if s.style == "points" else INK
            lines.append(replace(s, label=word, color=color, legend=True))
        yield replace(f, panels=(replace(f.panels[0], series=lines),))


linear_parameters = partial(named, chapter7.linear_parameters)
small_slip = partial(named, chapter7.parameters_over_factor)
steady_curves = partial(named, chapter7.steady_curves)
crossed = partial(named, chapter7.crossed_angles)
magic_fx = partial(named, magic.magic_curves, "magic_formula_fx")
magic_fy = partial(named, magic.magic_lateral, "magic_formula_fy")
