# SPDX-License-Identifier: Apache-2.0
"""Colours and type of all figures."""

from __future__ import annotations

from collections.abc import Sequence

INK = "#1d2733"
MUTED = "#6b7684"
GRID = "#e4e8ed"

#: tells up to six lines apart, also for colour-blind eyes
PALETTE = ("#1f6fb2", "#d1672b", "#3b8f6b", "#8b5fa8", "#b8902f", "#5b6672")

_BRAKING = ("#8fbfe8", "#5a9bd5", "#2a72b5", "#124a80")
_DRIVING = ("#f3b48b", "#e5864e", "#c65a22", "#8c3a10")
_NEUTRAL = "#5b6672"

RC = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9.0,
    "axes.labelsize": 9.0,
    "axes.titlesize": 9.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.edgecolor": MUTED,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": GRID,
    "grid.linewidth": 0.7,
    "text.color": INK,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "svg.fonttype": "none",
    "axes.unicode_minus": True,
}


def slip_colors(levels: Sequence[float]) -> dict[float, str]:
    """Blue for braking, orange for driving, the darker the larger; grey for none."""
    out = {level: _NEUTRAL for level in levels}
    for scale, chosen in (
        (_BRAKING, sorted((v for v in levels if v < 0), reverse=True)),
        (_DRIVING, sorted(v for v in levels if v > 0)),
    ):
        steps = max(len(chosen) - 1, 1)
        for i, level in enumerate(chosen):
            place = i * (len(scale) - 1) / steps if len(chosen) > 1 else len(scale) - 1
            out[level] = scale[round(place)]
    return out
