# SPDX-License-Identifier: Apache-2.0
"""Linear plant (5.9c), controller (5.12) and the figures of thesis 5.4, for the continuous and the
real loop.

J_eff is 1009.3 kg m2 by (5.5); the 1287 of Table 5.1 does not give the thesis's own results: it is
(5.5) with an efficiency of 0.50 in place of 0.392. The printed peak of H, 3.98 dB at 2.43 Hz, fits
neither: 1009.3 gives 3.93 dB at 2.55 Hz, 1287 gives 4.16 dB at 2.13 Hz.
"""

from __future__ import annotations

from dataclasses import dataclass

import control
from flatplank_control.free_rolling.design import Gains, Machine
from flatplank_control.free_rolling.loop import (
    Loop,
    controller_of,
    figures,
    plant_of,
    settling_time,
)
from flatplank_control.free_rolling.params import THESIS_LEAD_ALPHA, FreeRollingParameters

__all__ = [
    "Actuator", "Loop", "controller", "figures", "plant", "real_loop", "settling_time",
    "thesis_loop",
]  # fmt: skip

DELAY_CYCLES = 2
"""Cycles from a sample to its effect on the bench, without the zero-order hold."""


@dataclass(frozen=True)
class Actuator:
    """Wheel drive of Table 5.1, with J_eff by (5.5)."""

    efficiency: float = 0.392
    i_red: float = 30.32
    i_sd: float = 47.0
    j_m: float = 0.001260
    """[kg m2]"""
    j_ww: float = 0.2483
    j_ws: float = 0.005808
    j_t: float = 1.0
    vertical_force: float = 3700.0
    """[N]"""
    slip_stiffness: float = 24.5
    """normalised slip stiffness K'_x1"""
    effective_radius: float = 0.3081
    """[m]"""
    loaded_radius: float = 0.2955
    """[m]"""
    relaxation_length: float = 0.4505
    """[m]"""
    speed: float = 0.03092
    """V_x [m/s]"""

    @property
    def gear(self) -> float:
        """Gear ratio i of (5.14)."""
        return self.i_red * self.i_sd

    @property
    def j_eff(self) -> float:
        """Effective inertia by (5.5) [kg m2]."""
        worm = self.j_ws + self.i_red**2 * self.j_m
        return self.j_ww + self.j_t + self.efficiency * self.i_sd**2 * worm

    @property
    def j_tw(self) -> float:
        """Inertia J_T + J_WW + i_SD^2 J_WS of Table 5.1 [kg m2]."""
        return self.j_t + self.j_ww + self.i_sd**2 * self.j_ws


def plant(a: Actuator, j_eff: float | None = None) -> control.TransferFunction:
    """P(s) = Fx / M_M of (5.9c) [N / (N m)]."""
    machine = Machine(
        a.gear, a.efficiency, a.j_eff if j_eff is None else j_eff, a.effective_radius,
        a.loaded_radius, a.speed,
    )  # fmt: skip
    stiffness = a.slip_stiffness * a.vertical_force / a.relaxation_length
    return plant_of(stiffness, a.relaxation_length, machine)


def controller(p: FreeRollingParameters, alpha: float | None = None) -> control.TransferFunction:
    """C(s) of (5.12) [N m / N]; `alpha` overrides that of the lead."""
    lead_alpha = p.lead_alpha if alpha is None else alpha
    return controller_of(Gains(p.proportional_gain, p.integral_gain, p.lead_time, lead_alpha))


def thesis_loop(a: Actuator | None = None, j_eff: float | None = None) -> control.TransferFunction:
    """C(s) P(s) as in the thesis: no delay, alpha_l = 0.2174."""
    return controller(FreeRollingParameters(), THESIS_LEAD_ALPHA) * plant(a or Actuator(), j_eff)


def real_loop(
    p: FreeRollingParameters, a: Actuator | None = None, delay_cycles: int = DELAY_CYCLES
) -> control.TransferFunction:
    """C(z) P(z) z^-n at the rate of `p`: bilinear controller, zero-order hold, delay."""
    period = 1.0 / p.rate_hz
    sampled = control.sample_system(plant(a or Actuator()), period, "zoh")
    discrete = control.sample_system(controller(p), period, "bilinear")
    delay = control.tf([1.0], [1.0] + [0.0] * delay_cycles, period)
    return discrete * sampled * delay
