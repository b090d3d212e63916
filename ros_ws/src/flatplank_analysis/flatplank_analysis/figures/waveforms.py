# SPDX-License-Identifier: Apache-2.0
"""Runs whose slip is no step: force beside the driven linear model, frequency response."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from flatplank_analysis.figures import pieces
from flatplank_analysis.figures.registry import maker
from flatplank_analysis.figures.spec import Figure, Panel, Series
from flatplank_analysis.figures.style import INK, PALETTE
from flatplank_analysis.report.results import CampaignResult

SPAN = (0.8, 1.1)
"""Curves reach from this share of the lowest frequency of a run to this share of its highest."""


def _told(run: dict) -> str:
    """Parameters in words; waves much shorter than 2 pi sigma tell their ratio only."""
    sigma, stiffness = run["sigma"], 1e-3 * run["slip_stiffness"]
    if run["determined"]:
        return f"σx {sigma:.3f} m, C {stiffness:.1f} kN"
    return f"C/σx {stiffness / sigma:.0f} kN/m (waves this short do not tell σx and C apart)"


@maker("waveforms")
def waveforms(result: CampaignResult) -> Iterator[Figure]:
    """Slip above, force below."""
    for run in result.extras.get("waveforms", []):
        x = run["distance"]
        span = (0.0, float(x[-1]))
        slip = Series("", x, 100.0 * run["slip"], color=PALETTE[2])
        measured = Series("measured", x, run["fx"], color=PALETTE[0])
        model = Series("linear model", x, run["model"], "model", INK)
        yield Figure(
            f"waveform_{run['run']}",
            f"{run['waveform'].replace('_', ' ').capitalize()}, {run['run']}",
            f"Linear model driven by the measured slip: {_told(run)}, RMSE {run['rmse']:.0f} N.",
            (
                Panel(pieces.SINCE_STEP, "slip κ [%]", [slip], span),
                Panel(pieces.SINCE_STEP, pieces.FX, [measured, model], span),
            ),
            stacked=True,
        )


@maker("waveforms")
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
