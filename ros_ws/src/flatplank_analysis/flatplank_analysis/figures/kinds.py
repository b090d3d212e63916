# SPDX-License-Identifier: Apache-2.0
"""Cleat, parking, turning and camber sweep: measured beside modelled."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from flatplank_analysis.figures import pieces
from flatplank_analysis.figures.registry import maker
from flatplank_analysis.figures.spec import Figure, Panel, Series
from flatplank_analysis.figures.style import INK, PALETTE
from flatplank_analysis.kinds.camber_sweep import CamberSweep
from flatplank_analysis.kinds.cleat import Cleat
from flatplank_analysis.kinds.turning import Turning
from flatplank_analysis.report.results import CampaignResult

MZ = "aligning moment Mz [N m]"
ROAD = "road displacement [m]"


def _where(row: Mapping[str, Any]) -> str:
    return row["condition"].operating_point.label()


def _pair(
    x: np.ndarray, y: np.ndarray, model: np.ndarray, color: str = PALETTE[0]
) -> list[Series]:
    return [Series("measured", x, y, color=color), Series("model", x, model, "model", INK)]


@maker("special")
def cleats(result: CampaignResult) -> Iterator[Figure]:
    """Forces over the cleat, and the effective road that they tell."""
    for row in result.extras.get("cleat", []):
        found: Cleat = row["found"]
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
                Panel(away, "vertical force Fz [N]", _pair(x, found.fz, found.fz_modelled)),
                Panel(away, pieces.FX, _pair(x, found.fx, found.fx_modelled)),
                Panel(away, "effective road", [height, slope]),
            ),
        )


@maker("special")
def parkings(result: CampaignResult) -> Iterator[Figure]:
    """Moment over the steering angle, all loads in one picture."""
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


@maker("special")
def turnings(result: CampaignResult) -> Iterator[Figure]:
    """Heading, side force and moment over travel."""
    for row in result.extras.get("turning", []):
        yield _over_travel(
            f"turning_{row['run']}",
            f"Impulse turning, {_where(row)}",
            "A short turn of the steering of a rolling tire beside the linear brush on a carcass "
            "spring.",
            ("heading ψ [°]", row["found"].angle),
            row["found"],
        )


@maker("special")
def camber_sweeps(result: CampaignResult) -> Iterator[Figure]:
    """Camber, side force and moment over travel."""
    for row in result.extras.get("camber_sweep", []):
        yield _over_travel(
            f"camber_{row['run']}",
            f"Camber sweep, {_where(row)}",
            "The road is tilted under the rolling tire; the model follows the camber over a "
            "relaxation length.",
            ("camber γ [°]", row["found"].camber),
            row["found"],
        )


def _over_travel(
    name: str,
    title: str,
    caption: str,
    given: tuple[str, np.ndarray],
    found: Turning | CamberSweep,
) -> Figure:
    """The angle that was given [rad], and what side force and moment answered."""
    label, angle = given
    x = found.position
    panels = (
        Panel(ROAD, label, [Series("", x, np.degrees(angle), color=PALETTE[2])]),
        Panel(ROAD, pieces.FY, _pair(x, found.fy, found.fy_modelled)),
        Panel(ROAD, MZ, _pair(x, found.mz, found.mz_modelled)),
    )
    return Figure(name, title, caption, panels, stacked=True)
