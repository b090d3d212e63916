# SPDX-License-Identifier: Apache-2.0
"""The end of a run, where plank and wheel stop one after the other: a slip nobody asked for."""

from __future__ import annotations

import numpy as np

from flatplank_data.table import MeasurementTable

WINDOW = 0.1
"""half the time over which the plank's speed is taken [s]"""
FULL = 0.97
"""share of the usual speed from which on the plank has not begun to stop [-]"""


def until_stop(table: MeasurementTable) -> MeasurementTable:
    """The run up to the last moment at its usual speed; as it is where it does not stop."""
    time, position = table["time"], table["plank_position"]
    if len(time) < 3 or time[-1] - time[0] < 10.0 * WINDOW:
        return table
    before, after = (np.clip(time + d, time[0], time[-1]) for d in (-WINDOW, WINDOW))
    way = np.abs(np.interp(after, time, position) - np.interp(before, time, position))
    speed = way / (after - before)
    usual = float(np.median(speed[speed > 0.5 * speed.max()]))
    full = np.flatnonzero(speed >= FULL * usual)
    return table if full[-1] == len(time) - 1 else table.rows(slice(0, int(full[-1]) + 1))
