# SPDX-License-Identifier: Apache-2.0
"""Figures of chapter 6: those of a report, each by itself under the number of the thesis."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import partial

import numpy as np

from flatplank_analysis.figures import chapter6, machine, pieces
from flatplank_analysis.figures.spec import Figure, Panel, Series
from flatplank_analysis.post.gridding import low_pass, on_grid
from flatplank_analysis.report.results import CampaignResult
from flatplank_validation.thesis import plateau
from flatplank_validation.thesis.lab import Lab

BEARINGS = (2.1, 2.9, 3.2)
"""plank positions of the undulations, section 6.3 [m]"""
WELD = (1.6, 2.2)
"""road around the speed spike at 1.84 m, figure 6.23 [m]"""


def named(
    make: Callable[[CampaignResult], Iterable[Figure]], name: str, lab: Lab
) -> Iterator[Figure]:
    """The figure `name` of a maker of the report."""
    yield from (f for f in make(lab.matrix) if f.name == name)


def panel_of(
    make: Callable[[CampaignResult], Iterable[Figure]], name: str, axis: str, lab: Lab
) -> Iterator[Figure]:
    """One panel, by the label of its axis, of the figure `name` of a maker of the report."""
    for f in named(make, name, lab):
        panels = [p for p in f.panels if axis in (p.x_label, p.y_label)]
        yield Figure(f.name, f.title, f.caption, panels)


def varied(factor: str, channel: str, kappa: float, lab: Lab) -> Iterator[Figure]:
    """Figures 6.8 to 6.17: one factor varied at one slip."""
    for variation in pieces.variations(lab.matrix, factor):
        yield from chapter6.varied_channel(variation, channel, (kappa,))


def crossed(channel: str, kappa: float, lab: Lab) -> Iterator[Figure]:
    """Figures 6.18 to 6.21: side slip crossed with camber."""
    yield from chapter6.crossed_channel(lab.matrix, channel, kappa)


def plateaus(lab: Lab) -> Iterator[Figure]:
    """Figure 6.7."""
    yield from plateau.plateaus(lab.matrix)


def fluctuations(lab: Lab) -> Iterator[Figure]:
    """Figure 6.6."""
    yield from plateau.fluctuations(lab.matrix, BEARINGS)


def repeatability(lab: Lab) -> Iterator[Figure]:
    """Figure 6.22."""
    yield from chapter6.repeatability(lab.repeats)


def speeds(lab: Lab) -> Iterator[Figure]:
    """Figure 6.23: road speed of the ten runs of condition 4."""
    lines = []
    for table in condition(4, lab):
        grid = on_grid(table, ["plank_velocity"])
        lines.append(Series("", grid.position, 1e3 * low_pass(grid["plank_velocity"])))
    panel = Panel(pieces.ROAD, "road speed [mm/s]", lines, WELD)
    caption = "The ten runs at κ = 5 % and α = 5°, by the encoder of the pinion."
    yield Figure("road_speeds", "Road speed of repeated runs", caption, (panel,))


def condition(number: int, lab: Lab):
    """The ten runs of a condition of section 6.2."""
    kappa, alpha = {1: (0.01, 0.0), 2: (0.01, 5.0), 3: (0.05, 0.0), 4: (0.05, 5.0)}[number]
    if "repeats" not in lab.kept:
        columns = ("plank_position", "plank_velocity", "fx")
        lab.kept["repeats"] = lab.tables("repeats", columns) + lab.tables("repeats_torn", columns)
    return [
        t
        for t in lab.kept["repeats"]
        if (t.info.measurement, t.info.kappa, t.info.alpha_deg) == ("slip", kappa, alpha)
    ]


def scatter(number: int, lab: Lab) -> tuple[np.ndarray, np.ndarray, float]:
    """Road since the step [m], standard deviation of Fx and its largest mean [N]."""
    info = condition(number, lab)[0].info
    found = [
        c
        for c in lab.repeats.conditions
        if (c.condition.kappa, c.condition.alpha_deg) == (info.kappa, info.alpha_deg)
    ]
    c = found[0]
    assert c.scatter is not None
    keep = (c.since_step >= 0.0) & np.isfinite(c.scatter)
    return c.since_step[keep], c.scatter[keep], float(np.nanmax(np.abs(c.measured["fx"])))


rolling_radius = machine.rolling_radius
radius_over_load = partial(panel_of, rolling_radius, "rolling_radius", pieces.FZ)
radius_over_angle = partial(panel_of, rolling_radius, "rolling_radius", pieces.ALPHA)
forces = partial(named, chapter6.nominal_forces, "forces_nominal")
forces_zoom = partial(named, chapter6.nominal_forces, "forces_nominal_zoom")
road_speed = partial(named, chapter6.road_speed, "speed_and_load")
