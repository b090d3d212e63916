# SPDX-License-Identifier: Apache-2.0
"""Waves: harmonics over an angle; over a place a wave of any period, a beat, a decaying wave."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flatplank_analysis.effects.grammar.shapes.base import ANGLE, PLACE, Number, Shape, Span, Terms

_TIMES = ("once", "twice", "three times", "four times")


def periods(span: Span) -> np.ndarray:
    """Periods that are tried: at least three of them fit in the range."""
    return span.width / np.concatenate([np.arange(3.0, 45.0, 0.5), np.arange(45.0, 116.0, 0.75)])


def ends(span: Span) -> tuple[float, float]:
    """The shortest and the longest period that a fit may reach."""
    return span.width / 120.0, span.width / 2.9


def wave(u: np.ndarray, period: np.ndarray | float) -> tuple[np.ndarray, np.ndarray]:
    """Cosine and sine of this period."""
    angle = 2.0 * np.pi * u / period
    return np.cos(angle), np.sin(angle)


def harmonic(order: int) -> Callable[[np.ndarray, Span], tuple[np.ndarray, np.ndarray]]:
    """Formula of a wave so many times per turn."""
    return lambda u, s: (np.cos(order * u), np.sin(order * u))


def ringing(u: np.ndarray, s: Span, period: np.ndarray, fade: np.ndarray) -> Terms:
    """A wave after the event that dies away."""
    fading = (u > 0.0) * np.exp(-np.maximum(u, 0.0) / fade)
    cos, sin = wave(u, period)
    return fading * cos, fading * sin


PAIR = ("cos", "sin")
HARMONICS = tuple(
    Shape(f"harmonic {n}", f"waves {times} per turn", harmonic(n), (ANGLE,), sizes=PAIR)
    for n, times in enumerate(_TIMES, start=1)
)
WAVE = Shape(
    "wave",
    "waves with a period of its own",
    lambda u, s, period: wave(u, period),
    (PLACE,),
    (Number("period", "u", periods, ends),),
    PAIR,
    where="again every {period}",
)
BEAT = Shape(
    "beat",
    "waves with two periods, which swell and fade together",
    lambda u, s, period, second: (*wave(u, period), *wave(u, second)),
    (PLACE,),
    (Number("period", "u", periods, ends), Number("second", "u", periods, ends)),
    (*PAIR, "second_cos", "second_sin"),
    where="again every {period} and every {second}",
)
RINGING = Shape(
    "ringing",
    "waves after the event and dies away",
    ringing,
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
        ),
    ),
    PAIR,
    both_signs=True,
    where="again every {period}, falling to a third over {fade}",
)  # fmt: skip
