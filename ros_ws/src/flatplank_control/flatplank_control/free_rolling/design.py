# SPDX-License-Identifier: Apache-2.0
"""Computes gains of the free-rolling controller from the tire's stiffness, in closed form, fast
enough for the control loop.

Above its resonance the plant (5.9c) is gear eta C_x r_e / (J_eff s^2): of the tire, only
C_x = C_Fk / sigma sets the gain at the crossover. The delay of the loop sets the crossover. The
lead is centred on the crossover, and the gain follows from C_x.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from flatplank_data.machine import FAST, GEAR_RATIO

CROSSOVER = 20.0
"""crossover of the loop in the thesis, 3.14 Hz [rad/s]; used when the delay allows it"""
DELAY_PHASE = 0.32
"""largest phase of the delay at the crossover, 18 deg [rad]"""
LEAD_ALPHA = 0.08
"""alpha of the lead compensator; its largest phase is 58 deg"""
INTEGRAL_SHARE = 1.0 / 15.0
"""zero of the PI over the crossover; costs 3.8 deg of phase"""


class Gains(NamedTuple):
    """Gains of (5.12)."""

    proportional: float
    """[N m/N]"""
    integral: float
    """[N m/(N s)]"""
    lead_time: float
    """[s]"""
    lead_alpha: float


@dataclass(frozen=True)
class Machine:
    """Constants of the wheel drive in the loop; Table 5.1 with J_eff by (5.5)."""

    gear: float = GEAR_RATIO
    efficiency: float = 0.392
    inertia: float = 1009.3
    """J_eff [kg m2]"""
    effective_radius: float = 0.3081
    """[m]"""
    loaded_radius: float = 0.2955
    """[m]"""
    speed: float = FAST
    """[m/s]"""

    def response(self, omega: float, stiffness: float, relaxation: float) -> complex:
        """P(j omega) of (5.9c) [N/(N m)] for C_x [N/m] and sigma [m]."""
        s = 1j * omega
        turn = stiffness * self.effective_radius
        drag = self.speed / relaxation if math.isfinite(relaxation) else 0.0  # NaN: unknown
        below = self.inertia * s * (s + drag) + turn * self.loaded_radius
        return self.gear * self.efficiency * turn / below


def crossover_for(delay: float) -> float:
    """Crossover [rad/s] for a loop delay including the hold [s]."""
    return min(CROSSOVER, DELAY_PHASE / delay) if delay > 0.0 else CROSSOVER


def design_gains(
    stiffness: float, relaxation: float, delay: float, machine: Machine | None = None
) -> Gains:
    """Gains for C_x [N/m], sigma [m] and the loop delay including the hold [s].

    sigma may be infinite or NaN: it only damps the resonance, which is far below the crossover.
    """
    machine = machine or Machine()
    omega = crossover_for(delay)
    alpha, zero = LEAD_ALPHA, INTEGRAL_SHARE * omega
    lead_time = 1.0 / (omega * math.sqrt(alpha))
    plant = abs(machine.response(omega, stiffness, relaxation))
    lead = 1.0 / math.sqrt(alpha)
    pi = math.hypot(1.0, zero / omega)
    proportional = 1.0 / (plant * lead * pi)
    return Gains(proportional, zero * proportional, lead_time, alpha)
