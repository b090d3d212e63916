# SPDX-License-Identifier: Apache-2.0
"""Samples of a bench for the state of the panel, and its messages as the browser gets them."""

from __future__ import annotations

import json
import math

from flatplank_hw.bus.image import AXES, AxisInputs, BusInputs
from flatplank_hw.samples import DriveSample, EncoderSample, HubSample, Wrench
from flatplank_panel.bench_state import Samples
from flatplank_panel.signals import SIGNALS

COLUMN = {signal.key: i for i, signal in enumerate(SIGNALS)}


def samples(cycle: int, fz: float = 1.0) -> Samples:
    """A sample of every topic, of one cycle."""
    stamp = cycle * 4_000_000
    axes = (AxisInputs(0x27, 9, 0, 0, 0, 0),) * len(AXES)
    wrench = Wrench(1.0, 2.0, fz, 4.0, 5.0, 6.0)
    return Samples(
        BusInputs(cycle, stamp, (0.0,) * 6, 0.0, 0, 0, 0, 0, 0, 2, 0, axes),
        HubSample(cycle, stamp, wrench, wrench, 0.31, 0.0, fz, False, 0),
        EncoderSample(
            cycle, stamp, 0.5, 0.03, 1.0, 0.1, 0.0, 0.0, math.nan, 0.0, 0.0, True, True, 0.0
        ),
        DriveSample(cycle, stamp, 4, 3, 1.0, 0.1, 0.2, math.nan, 0.1, math.nan, 0, 0),
    )


def strict(message: dict) -> dict:
    """The message as the browser gets it."""
    return json.loads(json.dumps(message, allow_nan=False))
