# SPDX-License-Identifier: Apache-2.0
"""Figures of chapter 6: the measured forces over road displacement."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from flatplank_analysis.figures import pieces
from flatplank_analysis.figures.spec import INK, PALETTE, Figure, Panel, Series
from flatplank_analysis.report.results import CampaignResult

ZOOM = (0.1, 0.3)
"""road before and after the step in the zoomed figure [m]"""
FORCES = {"fx": pieces.FX, "fy": pieces.FY}
DIRECTIONS = {"fx": "Longitudinal", "fy": "Lateral"}
"""channel -> label of its axis, word of a title"""
SHOWN_SLIPS = (0.05, 0.01, -0.05, 0.1)


def nominal_forces(result: CampaignResult) -> Iterator[Figure]:
    """Figures 6.3 and 6.4: Fx at the nominal point, over the whole road and around the step."""
    point = result.nominal()
    if point is None:
        return
    conditions = pieces.slips(point)
    step = conditions[0].step_position
    lines = pieces.force_lines(conditions)
    end = step + pieces.step_window(conditions)[1]
    yield Figure(
        "forces_nominal",
        "Longitudinal force for every slip level",
        f"{point.point.label()}. Mean of the runs of each level, low-passed at 323 1/m. "
        "The dotted line is the slip step.",
        (Panel(pieces.ROAD, pieces.FX, lines, (0.0, end), marks=(step,)),),
        "6.3",
    )
    window = (step - ZOOM[0], step + ZOOM[1])
    zoomed = []
    for line in lines:
        keep = (line.x >= window[0]) & (line.x <= window[1])
        zoomed.append(replace(line, x=line.x[keep], y=line.y[keep]))
    yield Figure(
        "forces_nominal_zoom",
        "Around the step",
        "The same, close to the slip step: a plateau here is lost motion.",
        (Panel(pieces.ROAD, pieces.FX, zoomed, window, marks=(step,)),),
        "6.4",
    )


def road_speed(result: CampaignResult) -> Iterator[Figure]:
    """Figure 6.5 and the vertical force of figure 6.6."""
    point = result.nominal()
    if point is None:
        return
    conditions = pieces.slips(point)
    kappa = np.array([100.0 * c.condition.kappa for c in conditions])
    before = np.array([1e3 * c.facts.speed_before for c in conditions])
    after = np.array([1e3 * c.facts.speed_after for c in conditions])
    across = "desired slip κ [%]"
    lines = [
        Series("before the step", kappa, before, "joined"),
        Series("after the step", kappa, after, "joined"),
    ]
    panels = [Panel(across, "mean road speed [mm/s]", lines)]
    if any("fz" in c.measured for c in conditions):
        load = np.array([100.0 * c.facts.load_change for c in conditions])
        panels.append(Panel(across, "load change ΔFz [%]", [Series("", kappa, load, "joined")]))
    caption = "Road speed before and after the step, and the change of the vertical force with it."
    yield Figure("speed_and_load", "Road speed and load change", caption, panels, "6.5, Table 6.3")


def varied_forces(result: CampaignResult) -> Iterator[Figure]:
    """Figures 6.8 to 6.21: one factor varied, Fx and (with angles) Fy after the step."""
    for varied in pieces.variations(result):
        channels = ("fx", "fy") if varied.factor.endswith("_deg") else ("fx",)
        for channel in channels:
            yield from varied_channel(varied, channel, SHOWN_SLIPS)


def varied_channel(
    varied: pieces.Variation, channel: str, slips: Sequence[float], most: int = 2
) -> Iterator[Figure]:
    """Fx or Fy after the step, a line per level of the factor, a panel per slip."""
    panels: list[Panel] = []
    for kappa in slips:
        found = [(label, pieces.at_slip(p, kappa)) for p, label in varied.labelled]
        there = [(label, c) for label, c in found if c is not None and channel in c.measured]
        if len(there) < 2 or len(panels) == most:
            continue
        window = pieces.step_window(c for _, c in there)
        lines = [Series(label, c.since_step, c.measured[channel]) for label, c in there]
        y_label = FORCES[channel]
        title = f"κ = {pieces.percent(kappa)}"
        panels.append(Panel(pieces.SINCE_STEP, y_label, lines, window, title=title))
    yield from pieces.figure(
        f"{channel}_over_{varied.name}",
        f"{DIRECTIONS[channel]} force for different {varied.symbol}",
        "Everything else is nominal; distance counts from the slip step.",
        panels,
        "6.8 to 6.21",
    )


def crossed_forces(result: CampaignResult) -> Iterator[Figure]:
    """Figures 6.18 to 6.21: side slip crossed with camber, Fx and Fy at +5 and -5 % slip."""
    for channel in FORCES:
        for kappa in (0.05, -0.05):
            yield from crossed_channel(result, channel, kappa)


def crossed_channel(result: CampaignResult, channel: str, kappa: float) -> Iterator[Figure]:
    """A line per side slip angle; full without, dashed with camber."""
    lines, there = [], []
    for gamma, points in pieces.crossed(result).items():
        for point, color in zip(points, PALETTE, strict=False):
            c = pieces.at_slip(point, kappa)
            if c is None or channel not in c.measured:
                continue
            there.append(c)
            x, force = c.since_step, c.measured[channel]
            style = "dashed" if gamma else "line"
            if point is points[0]:
                lines.append(Series(f"γ = {gamma:g}°", x[:0], force[:0], style, INK))
            label = f"α = {point.point.alpha_deg:g}°"
            full = style == "line"
            lines.append(Series(label, x, force, style, color, end_label=full, legend=False))
    if not lines:
        return
    sign = "driving" if kappa > 0.0 else "braking"
    yield Figure(
        f"{channel}_crossed_{sign}",
        f"{DIRECTIONS[channel]} force, side slip and camber, κ = {pieces.percent(kappa)}",
        "Full: without camber; dashed: with it. Distance counts from the slip step.",
        (Panel(pieces.SINCE_STEP, FORCES[channel], lines, pieces.step_window(there)),),
        "6.18 to 6.21",
    )


def repeatability(result: CampaignResult) -> Iterator[Figure]:
    """Figure 6.22: standard deviation of Fx between repeats, relative to its largest value."""
    lines = []
    point = result.nominal()
    repeated = [c for c in result.conditions if c.same_start and c.scatter is not None]
    chosen = repeated or (pieces.slips(point) if point else [])
    tone = pieces.slip_colors(chosen)
    for c in chosen:
        if c.scatter is None or abs(c.condition.kappa) < 1e-6:
            continue
        largest = float(np.nanmax(np.abs(c.measured["fx"])))
        label = pieces.percent(c.condition.kappa)
        if c.condition.alpha_deg:
            label += f", α {c.condition.alpha_deg:g}°"
        keep = (c.since_step >= 0.0) & np.isfinite(c.scatter)
        color = tone[c.condition.kappa] if not repeated else ""
        values = _smooth(100 * c.scatter[keep] / largest)
        lines.append(Series(label, c.since_step[keep], values, color=color, end_label=True))
    if not lines:
        return
    over = "repeats from one start angle" if repeated else "the start angles"
    y_label = "standard deviation / largest Fx [%]"
    yield Figure(
        "repeatability",
        "Repeatability",
        f"Standard deviation of Fx over {over}, over the largest force; mean over 0.1 m of road.",
        (Panel(pieces.SINCE_STEP, y_label, lines, (0.0, float(max(s.x[-1] for s in lines)))),),
        "6.22",
    )


def _smooth(values: np.ndarray, width: int = 50) -> np.ndarray:
    """Moving mean over `width` values, over fewer at the ends."""
    ones = np.ones(min(width + 1 - width % 2, values.size))
    count = np.convolve(np.ones(values.size), ones, mode="same")
    return np.convolve(values, ones, mode="same") / count
