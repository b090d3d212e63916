# SPDX-License-Identifier: Apache-2.0
"""Estimates of M_yc, the moment of the tire about the spin axis, which the bridges do not measure.

Steady wheel: the drive moment and M_yc cancel, so a driven wheel has M_yc < 0. Second
recommendation of thesis chapter 8.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from flatplank_hw.bus.image import BusInputs
from flatplank_hw.cia402 import TORQUE_UNIT

if TYPE_CHECKING:
    from flatplank_hw.hub.params import HubParameters


def force_balance(inputs: BusInputs, fx: float, loaded_radius: float, p: HubParameters) -> float:
    """M_yc = -r_l Fx: all of the drive moment goes into Fx, rolling resistance is left out."""
    return -loaded_radius * fx


def motor_torque(inputs: BusInputs, fx: float, loaded_radius: float, p: HubParameters) -> float:
    """M_yc = -eta i (M_M - M_F); only for a driven wheel, the self-locking gear hides braking
    (5.3)."""
    torque = inputs.axes[0].torque * TORQUE_UNIT
    return -p.efficiency * p.gear_ratio * max(torque - p.friction_torque, 0.0)


SOURCES: dict[str, Callable[[BusInputs, float, float, HubParameters], float]] = {
    "force_balance": force_balance,
    "motor_torque": motor_torque,
}
