# SPDX-License-Identifier: Apache-2.0
"""Live data for all open pages, `PUSH_HZ` times a second; every page gets the same message."""

from __future__ import annotations

import json
import math
import time
from typing import Any

import numpy as np

from flatplank_data.wording import with_unit
from flatplank_panel.bench_state import BenchState
from flatplank_panel.signals import SIGNALS

PUSH_HZ = 12
EVENT = "live"
"""event on the page's socket; the browser would keep a message sent as JavaScript in memory"""
HISTORY = 2400
"""number of rows that a new page gets"""
DIGITS = 6
"""significant digits of a number in a message"""


def rows_of(table: np.ndarray) -> list[list[float | None]]:
    """Rows with rounded numbers; non-finite ones are None."""
    return [[_short(v) for v in row] for row in table.tolist()]


def _short(value: float) -> float | None:
    return float(f"{value:.{DIGITS}g}") if math.isfinite(value) else None


class LiveData:
    """Makes the messages with live data."""

    def __init__(self, state: BenchState) -> None:
        self.state = state
        self._serial = state.ring.serial
        self.pushed = 0

    def tick(self) -> dict[str, Any]:
        """Data since the last tick, as strict JSON."""
        now = time.monotonic()
        begun = self.state.ring.begun  # before the rows, to exclude rows of an older bus
        rows = rows_of(self.state.ring.since(self._serial))
        self._serial = self.state.ring.serial
        self.pushed += 1
        return {
            "serial": self._serial,
            "begun": begun,
            "rows": rows,
            "live": self.state.running(now),
            "words": self.state.state_texts(now),
        }

    def start(self) -> str:
        """JavaScript call for a page that has just opened."""
        signals = [
            {"key": s.key, "digits": s.digits, "name": with_unit(s.label, s.unit)} for s in SIGNALS
        ]
        ring = self.state.ring
        begun = ring.begun
        history = rows_of(ring.since(ring.serial - HISTORY))
        return f"fp.start('{EVENT}', {script(signals)}, {script(history)}, {ring.serial}, {begun})"


def script(value: Any) -> str:
    """JSON that is safe inside a script: it can neither end a tag nor start a comment."""
    text = json.dumps(value, allow_nan=False, ensure_ascii=True)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")
