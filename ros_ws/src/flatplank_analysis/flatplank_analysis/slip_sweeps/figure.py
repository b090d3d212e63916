# SPDX-License-Identifier: Apache-2.0
"""Measured and modelled force over the swept slip, a panel for each condition."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from flatplank_analysis.discovery.report.figures import BLUE, GREY, ORANGE, figure_of
from flatplank_analysis.slip_sweeps.conditions import FORCE
from flatplank_analysis.slip_sweeps.failing import Failure
from flatplank_analysis.slip_sweeps.levels import HELD
from flatplank_analysis.slip_sweeps.study import Study

MOST = 24
"""panels"""
SLIP = {"alpha": ("slip angle [deg]", 180.0 / math.pi), "kappa": ("slip [%]", 100.0)}


def curves(study: Study, found: Sequence[Failure] = ()) -> Figure:
    """The conditions, those in which the tire file is off most first."""
    order = list(range(len(study.conditions)))
    if found:
        order.sort(key=lambda k: -found[k].share)
    order = order[:MOST]
    across = min(4, len(order))
    down = math.ceil(len(order) / across)
    figure = figure_of(3.2 * across, 2.5 * down)
    panels = figure.subplots(down, across, squeeze=False).ravel()
    for panel, k in zip(panels, order, strict=False):
        _panel(panel, study, k, found)
    for panel in panels[len(order) :]:
        panel.set_visible(False)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), fontsize=8)
    return figure


def _panel(panel, study: Study, k: int, found: Sequence[Failure]) -> None:
    condition, curve, formula = study.conditions[k], study.curves[k], study.formulas[k]
    title, scale = SLIP[condition.swept]
    x = scale * curve.slip
    panel.fill_between(
        x, np.fmin(curve.up, curve.down), np.fmax(curve.up, curve.down), color=GREY, alpha=0.35,
        lw=0, label="measured, up and down",
    )  # fmt: skip
    panel.plot(x, curve.force, ".", ms=4, color=GREY, label="measured, mean")
    if formula:
        panel.plot(x, formula(curve.slip), lw=1, color=BLUE, label="B, C, D, E of this sweep")
    if found:
        panel.plot(x, found[k].modelled, lw=1.5, color=ORANGE, label="tire file")
    levels = [
        h.word(condition.held[h.name])
        for h in HELD
        if h.name in condition.held and h.name in condition.told
    ]
    panel.set_title(", ".join(levels[:4]), fontsize=7)
    panel.set_xlabel(title, fontsize=7)
    panel.set_ylabel(f"{FORCE[condition.swept].capitalize()} [N]", fontsize=7)
    panel.tick_params(labelsize=7)
    panel.spines[["top", "right"]].set_visible(False)
