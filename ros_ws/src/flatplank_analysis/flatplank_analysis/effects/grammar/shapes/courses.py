# SPDX-License-Identifier: Apache-2.0
"""Shapes over a range: constant, growing from an end or from a value on, a bump."""

from __future__ import annotations

import numpy as np

from flatplank_analysis.effects.grammar.shapes.base import LEVEL, PLACE, SIGNAL, Number, Shape

ANY = (PLACE, LEVEL, SIGNAL)

CONSTANT = Shape("constant", "is the same everywhere", lambda u, s: np.ones_like(u), ("none",))
RAMP = Shape(
    "ramp",
    "changes evenly from one end of the range to the other; the size is the whole change",
    lambda u, s: (u - s.middle) / s.width,
    ANY,
)
POWER = Shape(
    "power",
    "grows as a power of the distance from the lower end; the size is the whole change",
    lambda u, s, power: (np.maximum(u - s.low, 0.0) / s.width + 1e-9) ** power,
    ANY,
    (Number("power", "-", lambda s: (0.5, 1.5, 2.0, 2.5, 3.0, 4.0), lambda s: (0.3, 5.0)),),
)
RELAXATION = Shape(
    "relaxation",
    "goes to an end value, fast at first (exponential)",
    lambda u, s, length: 1.0 - np.exp(-np.maximum(u - s.begin, 0.0) / length),
    ANY,
    (
        Number(
            "length", "u",
            lambda s: s.width * np.geomspace(0.03, 0.6, 10),
            lambda s: (0.01 * s.width, 1.0 * s.width),
        ),
    ),
    after_event=True,
)  # fmt: skip
STEP = Shape(
    "step",
    "is there beyond one value only",
    lambda u, s, at: 0.5 + 0.5 * np.tanh((u - at) / s.edge),
    ANY,
    (
        Number(
            "at", "u",
            lambda s: s.shares(*(0.06 + 0.04 * i for i in range(23))),
            lambda s: (s.low, s.high),
        ),
    ),
    where="beyond {at}",
)  # fmt: skip
THRESHOLD = Shape(
    "threshold",
    "is nothing up to one value and grows evenly beyond it; the size is that over the whole range",
    lambda u, s, at: np.maximum(u - at, 0.0) / s.width,
    ANY,
    (
        Number(
            "at", "u",
            lambda s: s.shares(*(0.1 + 0.04 * i for i in range(20))),
            lambda s: (s.low, s.high - 0.05 * s.width),
        ),
    ),
    where="beyond {at}",
)  # fmt: skip
BUMP = Shape(
    "bump",
    "rises and falls between two places, like half a wave",
    lambda u, s, start, length: np.sin(np.pi * np.clip((u - start) / length, 0.0, 1.0)),
    (PLACE,),
    (
        Number(
            "start", "u",
            lambda s: s.shares(*np.arange(0.0, 0.94, 0.02)),
            lambda s: (s.low - 0.1 * s.width, s.high),
        ),
        Number(
            "length", "u",
            lambda s: s.width * np.geomspace(0.03, 0.4, 10),
            lambda s: (0.02 * s.width, 0.6 * s.width),
        ),
    ),
    where="from {start} on, over {length}",
)  # fmt: skip
