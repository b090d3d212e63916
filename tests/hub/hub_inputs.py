# SPDX-License-Identifier: Apache-2.0
"""Raw inputs for tests."""

from __future__ import annotations

from flatplank_hw.bus.image import AXES, AxisInputs, BusInputs, Digital
from flatplank_hw.hub.appendix_a import Gains, Volts
from flatplank_hw.samples import Wrench

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


def volts_from_wheel(wheel: Wrench, g: Gains) -> Volts:
    """Inverse of (A.1): C2, C3 from Fx, Mz; C5, C6 from Fz, Mx; C1 from Fy; C4 is zero."""
    span = g.outer - g.inner
    x1 = (wheel.mz + g.inner * wheel.fx) / span
    x2 = -wheel.fx - x1
    z1 = (wheel.mx - g.inner * wheel.fz) / span
    z2 = wheel.fz - z1
    return (wheel.fy / g.c1, x1 / g.c2, x2 / g.c3, 0.0, z2 / g.c5, z1 / g.c6)


def wheel_from_contact(contact: Wrench, loaded_radius: float, cos: float, sin: float) -> Wrench:
    """Inverse of (A.2), all six components."""
    fx, fy_w, fz_w, mx_w, my_w, mz_w = contact
    fy = cos * fy_w + sin * fz_w
    return Wrench(
        fx,
        fy,
        cos * fz_w - sin * fy_w,
        mx_w + loaded_radius * fy,
        cos * my_w + sin * mz_w - loaded_radius * fx,
        cos * mz_w - sin * my_w,
    )
