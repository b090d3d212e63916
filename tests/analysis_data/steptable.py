# SPDX-License-Identifier: Apache-2.0
"""One slip-step run with a known answer: a first-order response."""

from __future__ import annotations

import numpy as np

from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable

SPEED = 0.031
RADIUS = 0.31
SIGMA = 0.4
STIFFNESS = 9e4
RATE = 20.0


def step_table(
    kappa: float = 0.02, start: int = 1, noise: float = 0.0, **info
) -> MeasurementTable:
    """Force after a slip step at 1.5 m; the wheel follows at once."""
    seed = int(1e4 * (1.0 + kappa)) + start
    random = np.random.default_rng(seed)
    time = np.arange(round(4.2 / SPEED * RATE)) / RATE
    x = SPEED * time
    slip = np.where(x > 1.5, kappa, 0.0)
    angle = np.cumsum(np.append(0.0, np.diff(x))) * 1.0 / RADIUS
    angle = angle + np.maximum(x - 1.5, 0.0) * kappa / RADIUS
    force = STIFFNESS * kappa * -np.expm1(-np.maximum(x - 1.5, 0.0) / SIGMA)
    n = x.size
    columns = {
        "time": time,
        "plank_position": x,
        "plank_velocity": np.full(n, SPEED),
        "wheel_angle": angle,
        "wheel_velocity": SPEED * (1.0 + slip) / RADIUS,
        "motor_velocity": SPEED * (1.0 + slip) / RADIUS * 1425.04,
        "motor_torque": np.full(n, 2.0),
        "fx": force + noise * random.normal(size=n),
        "fy": np.zeros(n),
        "fz": np.full(n, 3700.0),
        "mx": np.zeros(n),
        "my": np.zeros(n),
        "mz": np.zeros(n),
        "loaded_radius": np.full(n, 0.3),
        "motion_trigger": np.ones(n),
    }
    facts = {
        "tire": "TOY",
        "kappa": kappa,
        "fz": 3700.0,
        "pressure": 2.5,
        "start": start,
        "effective_rolling_radius": RADIUS,
        "step_position": 1.5,
        "file": f"TOY_REL_LNG_{100 * kappa:g}perc_T_p25_Fz3700_{start}.parquet",
    }
    return MeasurementTable(columns, RunRecord(**{**facts, **info}))
