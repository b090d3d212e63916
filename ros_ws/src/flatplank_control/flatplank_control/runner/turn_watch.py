# SPDX-License-Identifier: Apache-2.0
"""The once-per-turn force that an unloaded wheel shows on the way to its start."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from flatplank_control.runner.steps import Snapshot
from flatplank_control.turning import turning_amplitude

LEAST_TURN = 2.0 * math.pi / 3.0
"""[rad]"""
FEWEST = 12
"""samples"""


class TurnWatch:
    """Looks at the unloaded wheel on the way to its start; `left` [N] is NaN when it turned too
    little to tell."""

    def __init__(self) -> None:
        self.filter_on = False
        self._rows: list[tuple[float, float, float]] = []

    def watching(self, until: Callable[[Snapshot], bool]) -> Callable[[Snapshot], bool]:
        """The same condition, with a look at every sample."""

        def check(s: Snapshot) -> bool:
            self.filter_on = s.hub.filter_on
            self._rows.append((s.encoders.wheel_angle, s.hub.contact.fx, s.hub.contact.fz))
            return until(s)

        return check

    @property
    def left(self) -> float:
        if len(self._rows) < FEWEST:
            return math.nan
        angle, fx, fz = np.array(self._rows).T
        if np.ptp(angle) < LEAST_TURN:
            return math.nan
        # a part of a turn: no drift beside the sine
        return float(turning_amplitude(angle, np.column_stack([fx, fz])).max())
