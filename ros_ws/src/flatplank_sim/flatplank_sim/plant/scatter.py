# SPDX-License-Identifier: Apache-2.0
"""What differs between two runs of the same condition: drawn anew at the motion trigger."""

from __future__ import annotations

import numpy as np

from flatplank_sim.plant.layout import MAP_START, MAP_STEP
from flatplank_sim.plant.records import Records


def scatters(r: Records) -> bool:
    """True when the machine has a defect that differs from run to run."""
    m = r.machine[0]
    return bool(m["scatter_travel"] > 0.0 or m["scatter_delay"] > 0.0 or m["weld_gap"] > 0.0)


def draw_run(r: Records, state: np.ndarray, random: np.random.Generator) -> None:
    """Draw the errors of the next run, from its motion trigger on."""
    m = r.machine[0]
    state["step_delay"] = m["scatter_delay"] * random.uniform()
    state["weld_hold"] = m["weld_hold"] * (1.0 + m["weld_spread"] * random.standard_normal())
    if m["scatter_travel"] > 0.0:
        x = np.arange(len(r.road_map)) * MAP_STEP - MAP_START - m["trigger_at"]
        teeth = np.arange(int(x[-1] / m["scatter_pitch"]) + 2)
        error = m["scatter_travel"] * random.standard_normal(len(teeth))
        error[0] = 0.0
        r.road_map[:, 3] = np.interp(x / m["scatter_pitch"], teeth, error)
