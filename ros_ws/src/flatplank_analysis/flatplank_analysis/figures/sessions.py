# SPDX-License-Identifier: Apache-2.0
"""Control charts of the reference tire."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from flatplank_analysis.figures.registry import maker
from flatplank_analysis.figures.spec import Figure, Panel, Series
from flatplank_analysis.figures.style import INK, PALETTE
from flatplank_analysis.report.results import CampaignResult


@maker("reference")
def control_charts(result: CampaignResult) -> Iterator[Figure]:
    """Mean of every session, mean of all and control limits."""
    for chart in result.extras.get("sessions", []):
        x = np.arange(1.0, len(chart.means) + 1.0)
        level = np.full_like(x, chart.centre)
        lines = [
            Series("session", x, chart.means, "joined", PALETTE[0]),
            Series("mean", x, level, "model", INK),
        ]
        if math.isfinite(chart.reach):
            for sign in (1.0, -1.0):
                limit = Series("limit", x, level + sign * chart.reach, "curve", PALETTE[3])
                lines.append(limit if sign > 0 else Series(*_quiet(limit)))
        told = "; ".join(chart.remarks) or "all sessions lie within the limits"
        yield Figure(
            f"reference_{chart.name}",
            f"Reference tire: {chart.title}",
            f"Sessions in their order, {chart.labels[0]} to {chart.labels[-1]}: {told}.",
            (Panel("session", f"{chart.name} [{chart.unit}]", lines),),
        )


def _quiet(s: Series) -> tuple:
    return s.label, s.x, s.y, s.style, s.color, None, False, False
