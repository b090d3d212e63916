# SPDX-License-Identifier: Apache-2.0
"""Shapes over a setting or a signal: with respect to zero, delayed, with hysteresis."""

from __future__ import annotations

import numpy as np

from flatplank_analysis.effects.grammar.shapes.base import (
    LEVEL,
    SIGNAL,
    Number,
    Shape,
    follow,
    play,
)

KINDS = (LEVEL, SIGNAL)

SIGN = Shape(
    "sign", "changes its sign with that of it", lambda u, s: np.tanh(u / s.edge), KINDS,
    both_signs=True,
)  # fmt: skip
SIZE = Shape(
    "size",
    "grows with the size, whatever the sign; the size is that over the whole range",
    lambda u, s: np.abs(u) / s.width,
    KINDS,
    both_signs=True,
)
DEAD_BAND = Shape(
    "dead band",
    "is nothing within a band about zero and grows evenly beyond it",
    lambda u, s, band: (u - np.clip(u, -band, band)) / s.width,
    KINDS,
    (
        Number(
            "band", "u", lambda s: s.width * np.linspace(0.06, 0.4, 8),
            lambda s: (0.02 * s.width, 0.45 * s.width),
        ),
    ),
    both_signs=True,
)  # fmt: skip
SATURATION = Shape(
    "saturation",
    "grows about zero and stays at an end value on either side",
    lambda u, s, scale: np.tanh(u / scale),
    KINDS,
    (
        Number(
            "scale", "u", lambda s: s.width * np.geomspace(0.03, 0.5, 8),
            lambda s: (0.015 * s.width, s.width),
        ),
    ),
    both_signs=True,
)  # fmt: skip
LAG = Shape(
    "lag",
    "follows it late (first order); the size is that over the whole range",
    lambda u, s, lag, time: (follow(u, time, lag) - s.middle) / s.width,
    (SIGNAL,),
    (Number("lag", "s", lambda s: np.geomspace(0.3, 60.0, 8), lambda s: (0.05, 200.0)),),
    memory=True,
)
PLAY = Shape(
    "play",
    "differs on the way forward and on the way back (play operator)",
    lambda u, s, gap, time: play(u, gap),
    (SIGNAL,),
    (
        Number(
            "gap", "u", lambda s: s.width * np.geomspace(0.01, 0.5, 8),
            lambda s: (0.005 * s.width, s.width),
        ),
    ),
    memory=True,
)  # fmt: skip
