# SPDX-License-Identifier: Apache-2.0
"""Raw inputs for tests."""

from __future__ import annotations

from flatplank_hw.bus.image import AXES, AxisInputs, BusInputs, Digital

PERIOD = 4_000_000
AXIS = AxisInputs(0x27, 9, 0, 0, 0, 0)


def bus(cycle: int = 0, period_ns: int = PERIOD, **fields) -> BusInputs:
    """Inputs of a cycle, all zero but what is given."""
    values = {
        "bridge_volts": (0.0,) * 6,
        "lvdt_volts": 0.0,
        "plank_counts": 0,
        "wheel_counts": 0,
        "steer_counts": 0,
        "camber_counts": 0,
        "road_counts": 0,
        "digital": int(Digital.EMERGENCY_STOP_OK),
        "health": 0,
        "axes": (AXIS,) * len(AXES),
    }
    return BusInputs(cycle=cycle, stamp_ns=cycle * period_ns, **{**values, **fields})
