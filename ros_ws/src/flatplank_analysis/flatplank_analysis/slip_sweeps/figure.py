# SPDX-License-Identifier: Apache-2.0
"""The figure of sweeps: measured and modelled curves, a panel for each force and moment."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flatplank_analysis.discovery.report.figures import BLUE, GREY, ORANGE, clean, figure_of
from flatplank_analysis.slip_sweeps.conditions import FORCE, SweepCondition
from flatplank_analysis.slip_sweeps.curves import Curve, Failure
from flatplank_analysis.slip_sweeps.formula import Formula
from flatplank_analysis.slip_sweeps.moment import MOMENT
from flatplank_analysis.slip_sweeps.study import Study
from flatplank_analysis.slip_sweeps.tir_signs import READ
from flatplank_tire.tir import TirFile

PANELS = 24
"""most panels of a figure"""
WIDTH, HEIGHT, ACROSS = 3.2, 2.5, 4
"""size of a panel [inch], and most panels beside each other"""
TITLED = 4
"""most levels in the title of a panel"""
SMALL, BAND = {"fontsize": 7}, {"alpha": 0.35, "lw": 0, "label": "measured, up and down"}
POINTS = {"ms": 4, "label": "measured, mean"}
FORMULA = {"lw": 1, "label": "B, C, D, E of this sweep"}
MODEL = {"lw": 1.5, "label": "tire file"}
LEGEND = {"loc": "outside upper center", "fontsize": 8}


class Shown(NamedTuple):
    """A panel: a channel of a condition, with what is drawn beside it."""

    condition: SweepCondition
    title: str
    curve: Curve
    formula: Formula | None
    failure: Failure | None


def figure_of_sweeps(study: Study, tir: TirFile | None = None, signs: str = READ) -> Figure:
    """Force over the swept slip, a panel per condition, and Mz of each where it was measured.

    The largest errors of the tire file come first; signs: one of `CONVENTIONS`.
    """
    shown = [*_worst_first(_forces(study, tir, signs)), *_worst_first(_moments(study, tir, signs))]
    shown = shown[:PANELS]
    across = min(ACROSS, len(shown))
    down = math.ceil(len(shown) / across)
    figure = figure_of(WIDTH * across, HEIGHT * down)
    panels = figure.subplots(down, across, squeeze=False).ravel()
    for panel, one in zip(panels, shown, strict=False):
        _draw(panel, one)
    for panel in panels[len(shown) :]:
        panel.set_visible(False)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, ncols=len(labels), **LEGEND)
    return figure


def _forces(study: Study, tir: TirFile | None, signs: str) -> Iterator[Shown]:
    found = study.failures(tir, signs) if tir else [None] * len(study.conditions)
    rows = zip(study.conditions, study.curves, study.formulas, found, strict=True)
    for condition, curve, formula, failure in rows:
        title = f"{FORCE[condition.swept].capitalize()} [N]"
        yield Shown(condition, title, curve, formula, failure)


def _moments(study: Study, tir: TirFile | None, signs: str) -> Iterator[Shown]:
    found = study.moment_failures(tir, signs) if tir else {}
    for k, curve in study.moments.items():
        title = f"{MOMENT.capitalize()} [Nm]"
        yield Shown(study.conditions[k], title, curve, None, found.get(k))


def _worst_first(shown: Iterator[Shown]) -> list[Shown]:
    return sorted(shown, key=lambda one: -one.failure.share if one.failure else 0.0)


def _draw(panel: Axes, one: Shown) -> None:
    condition, curve = one.condition, one.curve
    slip = condition.slip
    x = slip.scale * curve.slip
    low, high = np.fmin(curve.up, curve.down), np.fmax(curve.up, curve.down)
    panel.fill_between(x, low, high, color=GREY, **BAND)
    panel.plot(x, curve.force, ".", color=GREY, **POINTS)
    if one.formula:
        panel.plot(x, one.formula(curve.slip), color=BLUE, **FORMULA)
    if one.failure:
        panel.plot(x, one.failure.modelled, color=ORANGE, **MODEL)
    levels = [h.word(condition.held[h.name]) for h in condition.levels()]
    panel.set_title(", ".join(levels[:TITLED]), **SMALL)
    panel.set_xlabel(f"{slip.title} [{slip.unit}]", **SMALL)
    panel.set_ylabel(one.title, **SMALL)
    clean(panel)
