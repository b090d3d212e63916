# SPDX-License-Identifier: Apache-2.0
"""Slip, load and road speed before and after a step (Table 6.3, figure 6.5); end of a run."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flatplank_data.stops import WINDOW, speed_of
from flatplank_data.table import MeasurementTable

WINDOW_BEFORE = 0.5
"""length of road before the step that counts as free rolling [m]"""
ROUND_OFF = 1e-12
"""relative difference of two means of one number, whose sums round to some hundred last digits"""
GUARD = 0.01
"""road after the step in which the wheel changes its speed; left out [m]"""


@dataclass(frozen=True)
class StepFacts:
    """Averages before and after a step; SI, slip as a fraction; NaN where not measured."""

    kappa: float
    """desired slip"""
    kappa_before: float
    kappa_actual: float
    """slip after the step, from turned angle and travelled road"""
    fz_before: float
    fz_after: float
    speed_before: float
    speed_after: float

    @property
    def load_change(self) -> float:
        """Delta F_z as a fraction of the load before the step; NaN where the load is one number
        throughout, a nominal load that nobody measured."""
        change = self.fz_after / self.fz_before - 1.0
        return change if abs(change) > ROUND_OFF else math.nan


def step_facts(table: MeasurementTable) -> StepFacts:
    """Facts of one run with a slip step, from angles and travel instead of noisy velocities."""
    info = table.info
    x = table["plank_position"]
    step = info.step_position if math.isfinite(info.step_position) else float(x[0])
    before = (x >= step - WINDOW_BEFORE) & (x < step)
    after = x >= step + GUARD
    if not before.any():
        before = x < step
    radius = info.effective_rolling_radius * 1.0 / math.cos(math.radians(info.alpha_deg))
    fz = table.get("fz")
    return StepFacts(
        info.kappa,
        radius * _ratio(table, "wheel_angle", before) - 1.0,
        radius * _ratio(table, "wheel_angle", after) - 1.0,
        _mean(fz, before),
        _mean(fz, after),
        _speed(table, before),
        _speed(table, after),
    )


def _ratio(table: MeasurementTable, name: str, mask: np.ndarray) -> float:
    """Change of a column per metre of road; least squares, so that encoder steps average out."""
    if mask.sum() < 3 or not table.has(name):
        return math.nan
    x, y = table["plank_position"][mask], table[name][mask]
    x = x - x.mean()
    spread = float(x @ x)
    return float(x @ (y - y.mean())) / spread if spread > 0.0 else math.nan


def _speed(table: MeasurementTable, mask: np.ndarray) -> float:
    slowness = _ratio(table, "time", mask)
    return 1.0 / slowness if slowness else math.nan


def _mean(values: np.ndarray, mask: np.ndarray) -> float:
    chosen = values[mask]
    chosen = chosen[np.isfinite(chosen)]
    return float(chosen.mean()) if chosen.size else math.nan


FULL = 0.97
"""share of the usual speed below which the plank is stopping [-]"""


def until_stop(table: MeasurementTable) -> MeasurementTable:
    """The run up to the last moment at its usual speed; unchanged where it does not stop."""
    time, position = table["time"], table["plank_position"]
    if len(time) < 3 or time[-1] - time[0] < 10.0 * WINDOW:
        return table
    speed = np.abs(speed_of(time, position))
    usual = float(np.median(speed[speed > 0.5 * speed.max()]))
    full = np.flatnonzero(speed >= FULL * usual)
    return table if full[-1] == len(time) - 1 else table.rows(slice(0, int(full[-1]) + 1))
