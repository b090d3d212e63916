# SPDX-License-Identifier: Apache-2.0
"""What really happened in a step: actual slip, load change, road speed (Table 6.3, figure 6.5)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flatplank_data.table import MeasurementTable

WINDOW_BEFORE = 0.5
"""length of road before the step that counts as free rolling [m]"""
GUARD = 0.01
"""left out after the step: the wheel needs this long to change its speed [m]"""


@dataclass(frozen=True)
class StepFacts:
    """Averages before and after a step; SI, slip as a fraction; NaN where not measured."""

    kappa: float
    """desired slip"""
    kappa_before: float
    kappa_actual: float
    """from the turned angle and the travelled road after the step"""
    fz_before: float
    fz_after: float
    speed_before: float
    speed_after: float

    @property
    def load_change(self) -> float:
        """Delta F_z as a fraction of the load before the step."""
        return self.fz_after / self.fz_before - 1.0


def step_facts(table: MeasurementTable) -> StepFacts:
    """Facts of one run with a slip step; angles and travel are used, not noisy velocities."""
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
