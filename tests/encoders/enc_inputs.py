# SPDX-License-Identifier: Apache-2.0
"""Raw inputs of encoders for tests."""

from __future__ import annotations

from flatplank_hw.bus.image import AXES, AxisInputs, BusInputs, Digital

OK = int(Digital.EMERGENCY_STOP_OK)
TRIGGER = OK | int(Digital.TRIGGER)


def wrap(counts: int) -> int:
    """As the int32 on the bus."""
    return (counts + 2**31) % 2**32 - 2**31


def image(n, plank=0, wheel=0, motor=0, period_ns=4_000_000, mode=9, **fields) -> BusInputs:
    """Cycle n with unwrapped counts."""
    axis = AxisInputs(0x27, mode, wrap(motor), 0, 0, 0)
    rest = AxisInputs(0x27, 0, 0, 0, 0, 0)
    values = {
        "bridge_volts": (0.0,) * 6,
        "lvdt_volts": 0.0,
        "plank_counts": wrap(plank),
        "wheel_counts": wrap(wheel),
        "steer_counts": 0,
        "camber_counts": 0,
        "road_counts": 0,
        "digital": OK,
        "health": 0,
        "axes": (axis,) + (rest,) * (len(AXES) - 1),
    }
    return BusInputs(cycle=n, stamp_ns=n * period_ns, **{**values, **fields})
