# SPDX-License-Identifier: Apache-2.0
"""Waves: harmonics over an angle; over a place a wave of any period, a beat, a decaying wave."""

from __future__ import annotations

import numpy as np

from flatplank_analysis.proposal.shapes.base import ANGLE, PLACE, Number, Shape, Span

_TIMES = ("once", "twice", "three times", "four times")


def periods(span: Span) -> np.ndarray:
    """Periods that are tried: at least three of them fit in the range."""
    return span.width / np.concatenate([np.arange(3.0, 45.0, 0.5), np.arange(45.0, 116.0, 0.75)])


def ends(span: Span) -> tuple[float, float]:
    """The shortest and the longest period that a fit may reach."""
    return span.width / 120.0, span.width / 2.9


HARMONICS = tuple(
    Shape(
        f"harmonic {n}", f"waves {times} per turn",
        (f"np.cos({n} * u)", f"np.sin({n} * u)"), (ANGLE,),
    )
    for n, times in enumerate(_TIMES, start=1)
)  # fmt: skip
WAVE = Shape(
    "wave",
    "waves with a period of its own",
    ("np.cos(wave)", "np.sin(wave)"),
    (PLACE,),
    (Number("period", "u", periods, ends),),
    parts=(("wave", "2.0 * np.pi * u / {period}"),),
    where="again every {period}",
)
BEAT = Shape(
    "beat",
    "waves with two periods, which swell and fade together",
    ("np.cos(wave)", "np.sin(wave)", "np.cos(other)", "np.sin(other)"),
    (PLACE,),
    (Number("period", "u", periods, ends), Number("second", "u", periods, ends)),
    parts=(("wave", "2.0 * np.pi * u / {period}"), ("other", "2.0 * np.pi * u / {second}")),
    where="again every {period} and every {second}",
)
RINGING = Shape(
    "ringing",
    "waves after the event and dies away",
    ("fading * np.cos(wave)", "fading * np.sin(wave)"),
    (PLACE,),
    (
        Number(
            "period", "u",
            lambda s: s.width / np.arange(4.0, 40.0, 1.0),
            lambda s: (s.width / 60.0, s.width),
        ),
        Number(
            "fade", "u",
            lambda s: s.width * np.array([0.05, 0.1, 0.2, 0.35]),
            lambda s: (0.01 * s.width, 2.0 * s.width),
            "length over which it falls to a third",
        ),
    ),
    both_signs=True,
    parts=(
        ("wave", "2.0 * np.pi * u / {period}"),
        ("fading", "(u > 0.0) * np.exp(-np.maximum(u, 0.0) / {fade})"),
    ),
    where="again every {period}, falling to a third over {fade}",
)  # fmt: skip
