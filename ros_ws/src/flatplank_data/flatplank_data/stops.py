# SPDX-License-Identifier: Apache-2.0
"""Where the wheel was stopped while the road moved: what follows is no rolling tire.

The state of the wheel's drive says it; without this state, the motion of the wheel does.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from flatplank_data.machine import SLOW, USABLE_ROAD

ENABLED = 4
"""`state` of a DriveStatus: CiA 402 operation enabled"""
MOVING = 0.2
"""the plank moves above this share of its usual speed, at least of its slow one [-]"""
LOCKED = 0.05
"""a wheel is locked when its rim is slower than this share of its usual speed over the road [-]"""
WINDOW = 0.1
"""half of the time window for speeds [s]"""
COLUMNS = (
    "time", "plank_position", "wheel_angle", "wheel_velocity", "drive_state", "stop_reason",
)  # fmt: skip

Columns = Mapping[str, np.ndarray]


class WheelStop(NamedTuple):
    """First stop of the wheel."""

    row: int
    """first sample of the stopped wheel"""
    position: float
    """plank position [m]"""
    code: int
    """`stop_reason` of the DriveStatus; 0: not recorded"""


def speed_of(time: np.ndarray, way: np.ndarray) -> np.ndarray:
    """Speed (n,) over a window of time that averages encoder steps."""
    before, after = (np.clip(time + d, time[0], time[-1]) for d in (-WINDOW, WINDOW))
    travel, span = np.interp(after, time, way) - np.interp(before, time, way), after - before
    # stamps so large (ns for s) that the window is less than their last digit: no speed
    return np.divide(travel, span, out=np.zeros_like(travel), where=span > 0.0)


def road_moves(columns: Columns) -> np.ndarray:
    """Mask (n,) of the samples in which the plank moves; none where no time passes."""
    time = columns["time"]
    if len(time) < 3 or not np.all(np.diff(time) > 0.0):
        return np.zeros(len(time), bool)
    speed = np.abs(speed_of(time, columns["plank_position"]))
    # the steps of the encoder of a standing plank are no motion
    return speed > MOVING * max(float(np.nanpercentile(speed, 90)), SLOW)


def wheel_stop(columns: Columns) -> WheelStop | None:
    """The first stop of a wheel that had been driven, or had rolled; None without one.

    A stop at the end of the usable road ends a whole run, and is none.
    """
    if not {"time", "plank_position"} <= columns.keys():
        return None
    moving = road_moves(columns)
    rows = _left_operation(columns, moving)
    rows = rows if rows is not None else _locked(columns, moving)
    x = columns["plank_position"]
    if not rows.size or abs(x[rows[0]] - x[0]) >= USABLE_ROAD:
        return None
    row = int(rows[0])
    codes = columns.get("stop_reason", np.zeros(0))[row:]
    codes = codes[np.isfinite(codes) & (codes > 0.0)]
    return WheelStop(row, float(x[row]), int(codes[0]) if codes.size else 0)


def _left_operation(columns: Columns, moving: np.ndarray) -> np.ndarray | None:
    """Samples in which a drive that had been enabled on the moving road is not; None where its
    state was not recorded."""
    state = columns.get("drive_state", np.zeros(0))
    if not np.isfinite(state).any():
        return None
    known = moving & np.isfinite(state)
    driven = np.logical_or.accumulate(known & (state == ENABLED))
    return np.flatnonzero(known & driven & (state != ENABLED))


def _locked(columns: Columns, moving: np.ndarray) -> np.ndarray:
    """Samples in which a wheel that had rolled stands on the moving road."""
    if not moving.any():
        return np.zeros(0, int)
    time = columns["time"]
    omega = columns.get("wheel_velocity", np.zeros(0))
    if "wheel_angle" in columns and np.isfinite(columns["wheel_angle"]).all():
        omega = speed_of(time, np.unwrap(columns["wheel_angle"]))
    if not np.isfinite(omega).any():
        return np.zeros(0, int)
    turns = np.abs(omega)
    rolls = turns > LOCKED * float(np.nanpercentile(turns[moving], 90))
    rolled = np.logical_or.accumulate(moving & rolls)
    rows = np.flatnonzero(moving & rolled & ~rolls)
    return np.append(_brakes(time, turns, int(rows[0])), rows) if rows.size else rows


def _brakes(time: np.ndarray, turns: np.ndarray, row: int) -> int:
    """First sample in which the wheel that stands in `row` is slower than in the second before."""
    late = time[row] - 2.0 * WINDOW
    before = turns[(time > late - 10.0 * WINDOW) & (time <= late)]
    usual = float(np.median(before)) if before.size else 0.0
    full = np.flatnonzero(turns[:row] >= (1.0 - LOCKED) * usual)
    return int(full[-1]) + 1 if full.size else row
