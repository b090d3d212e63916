# SPDX-License-Identifier: Apache-2.0
"""Figures of measurements without a slip step: waveforms, cleat, parking, turning, camber sweep,
reference tire."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from flatplank_analysis.figures import pieces
from flatplank_analysis.figures.spec import INK, PALETTE, Figure, Panel, Series
from flatplank_analysis.report.results import CampaignResult
from flatplank_analysis.report.sessions import ControlChart

SPAN = (0.8, 1.1)
"""Range of the curves: shares of the lowest and of the highest frequency of a run."""


def _fitted(run: dict) -> str:
    """sigma_x and C as text; waves much shorter than 2 pi sigma determine only their ratio."""
    sigma, stiffness = run["sigma"], 1e-3 * run["slip_stiffness"]
    if run["determined"]:
        return f"σx {sigma:.3f} m, C {stiffness:.1f} kN"
    return f"C/σx {stiffness / sigma:.0f} kN/m (waves this short do not tell σx and C apart)"


def waveforms(result: CampaignResult) -> Iterator[Figure]:
    """One figure per waveform run: slip above, force below."""
    for run in result.extras.get("waveforms", []):
        x = run["distance"]
        span = (0.0, float(x[-1]))
        slip = Series("", x, 100.0 * run["slip"], color=PALETTE[2])
        force = (x, run["fx"], run["model"], "linear model")
        yield Figure(
            f"waveform_{run['run']}",
            f"{run['waveform'].replace('_', ' ').capitalize()}, {run['run']}",
            f"Linear model driven by the measured slip: {_fitted(run)}, RMSE {run['rmse']:.0f} N.",
            (
                Panel(pieces.SINCE_STEP, pieces.SLIP, [slip], span),
                pieces.pair(pieces.SINCE_STEP, pieces.FX, *force, span),
            ),
            stacked=True,
        )


def frequency(result: CampaignResult) -> Iterator[Figure]:
    """Gain and phase over path frequency, of all periodic runs."""
    runs = [r for r in result.extras.get("waveforms", []) if "frequency" in r]
    if not runs:
        return
    gain, phase = [], []
    for run, color in zip(runs, PALETTE * 4, strict=False):
        f = run["frequency"]
        label = f"{run['waveform']}, {1.0 / float(f.min()):.2g} m"
        gain.append(Series(label, f, 1e-3 * run["gain"], "points", color))
        phase.append(Series(label, f, run["phase_deg"], "points", color))
        fine = np.linspace(SPAN[0] * float(f.min()), SPAN[1] * float(f.max()), 200)
        h = run["slip_stiffness"] / (1.0 + 2j * np.pi * fine * run["sigma"])
        gain.append(Series("model", fine, 1e-3 * np.abs(h), "curve", color, legend=False))
        line = np.degrees(np.angle(h))
        phase.append(Series("model", fine, line, "curve", color, legend=False))
    yield Figure(
        "frequency_response",
        "Frequency response over path frequency",
        "Points: lines of the slip's spectrum. Curves: the linear model of the same run, over the "
        "frequencies that the run has.",
        (
            Panel("path frequency [1/m]", "gain |Fx/κ| [kN]", gain),
            Panel("path frequency [1/m]", "phase [°]", phase),
        ),
    )


MZ = "aligning moment Mz [N m]"


def _where(row: Mapping[str, Any]) -> str:
    return row["condition"].operating_point.label()


def cleats(result: CampaignResult) -> Iterator[Figure]:
    """Forces over the cleat, and the effective road derived from them."""
    for row in result.extras.get("cleat", []):
        found = row["found"]
        x = 1e3 * found.distance
        away = "distance from the cleat's middle [mm]"
        height = Series("height [mm]", x, 1e3 * found.effective_height, color=PALETTE[2])
        slope = Series("slope [%]", x, 100.0 * found.effective_slope, color=PALETTE[1])
        yield Figure(
            f"cleat_{row['run']}",
            f"Cleat of {1e3 * found.height:g} mm, {_where(row)}",
            "Load and longitudinal force at a fixed axle beside the two-cam model, and the "
            "effective height and slope of the road that the forces tell.",
            (
                pieces.pair(away, pieces.FZ, x, found.fz, found.fz_modelled),
                pieces.pair(away, pieces.FX, x, found.fx, found.fx_modelled),
                Panel(away, "effective road", [height, slope]),
            ),
        )


def parkings(result: CampaignResult) -> Iterator[Figure]:
    """Moment over the steering angle, all loads in one figure."""
    rows = result.extras.get("parking", [])
    if not rows:
        return
    lines = []
    for row, color in zip(rows, PALETTE * 4, strict=False):
        found = row["found"]
        angle = np.degrees(found.angle)
        lines.append(Series(_where(row), angle, found.moment, color=color))
        shown = row is rows[-1]
        lines.append(Series("model", angle, found.modelled, "model", INK, legend=shown))
    panel = Panel("steering angle ψ [°]", MZ, lines)
    caption = "The standing tire is steered to and fro; dashed: the model with Masing's rule."
    yield Figure("parking", "Parking", caption, (panel,))


TRAVEL = {
    "turning": (
        "turning",
        "Impulse turning",
        "A short turn of the steering of a rolling tire beside the linear brush on a carcass "
        "spring.",
        ("heading ψ [°]", "angle"),
    ),
    "camber_sweep": (
        "camber",
        "Camber sweep",
        "The road is tilted under the rolling tire; the model follows the camber over a "
        "relaxation length.",
        ("camber γ [°]", "camber"),
    ),
}
"""kind -> prefix of the name, title, caption; label and attribute [rad] of the input angle"""


def over_travel(result: CampaignResult) -> Iterator[Figure]:
    """Impulse turning, camber sweep: the angle, and the response of side force and moment."""
    for kind, (name, title, caption, (label, angle)) in TRAVEL.items():
        for row in result.extras.get(kind, []):
            found = row["found"]
            x, given = found.position, np.degrees(getattr(found, angle))
            panels = (
                Panel(pieces.ROAD, label, [Series("", x, given, color=PALETTE[2])]),
                pieces.pair(pieces.ROAD, pieces.FY, x, found.fy, found.fy_modelled),
                pieces.pair(pieces.ROAD, MZ, x, found.mz, found.mz_modelled),
            )
            where = f"{title}, {_where(row)}"
            yield Figure(f"{name}_{row['run']}", where, caption, panels, stacked=True)


def control_charts(result: CampaignResult) -> Iterator[Figure]:
    """One figure per quantity, a panel per bench: mean of every session, mean of all sessions,
    control limits."""
    charts = result.extras.get("sessions", [])
    for name in dict.fromkeys(chart.name for chart in charts):
        own = [chart for chart in charts if chart.name == name]
        first = own[0]
        told = [_about(chart) for chart in own]
        yield Figure(
            f"reference_{name}",
            f"Reference tire: {first.title}",
            f"Sessions in their order, {' '.join(told)}",
            [_control_panel(chart) for chart in own],
            stacked=True,
        )


def _about(chart: ControlChart) -> str:
    """What the caption says of one bench."""
    bench = f"{chart.bench}: " if chart.bench else ""
    remarks = "; ".join(chart.remarks) or "all sessions lie within the limits"
    return f"{bench}{chart.labels[0]} to {chart.labels[-1]}: {remarks}."


def _control_panel(chart: ControlChart) -> Panel:
    x = np.arange(1.0, len(chart.means) + 1.0)
    level = np.full_like(x, chart.centre)
    lines = [
        Series("session", x, chart.means, "joined", PALETTE[0]),
        Series("mean", x, level, "model", INK),
    ]
    if math.isfinite(chart.reach):
        for sign in (1.0, -1.0):
            limit = level + sign * chart.reach
            lines.append(Series("limit", x, limit, "curve", PALETTE[3], legend=sign > 0))
    return Panel("session", f"{chart.name} [{chart.unit}]", lines, title=chart.bench)
