# SPDX-License-Identifier: Apache-2.0
"""Linear plant (5.9c), controller (5.12) and the figures of thesis 5.4, for the continuous and the
real loop.

J_eff is 1009.3 kg m2 by (5.5); the 1287 of Table 5.1 does not give the thesis's own results.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

import control
from flatplank_control.free_rolling.params import THESIS_LEAD_ALPHA, FreeRollingParameters

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


class Loop(NamedTuple):
    """Figures of a loop. Margins are those at the last crossover."""

    phase_margin: float
    """[deg]"""
    crossover: float
    """[Hz]"""
    gain_margin: float
    """[-]"""
    bandwidth: float
    """-3 dB of H [Hz]"""
    peak: float
    """peak of H [dB]"""
    peak_at: float
    """[Hz]"""
    dip_at: float
    """smallest S left of the crossover [Hz]"""


def plant(a: Actuator, j_eff: float | None = None) -> control.TransferFunction:
    """P(s) = Fx / M_M of (5.9c) [N / (N m)]."""
    stiffness = a.slip_stiffness * a.vertical_force * a.effective_radius
    inertia = a.j_eff if j_eff is None else j_eff
    v = a.speed
    return control.tf(
        [a.gear * a.efficiency * stiffness * v],
        [v * inertia * a.relaxation_length, v * inertia * v, stiffness * a.loaded_radius * v],
    )


def controller(p: FreeRollingParameters, alpha: float | None = None) -> control.TransferFunction:
    """C(s) of (5.12) [N m / N]; `alpha` overrides that of the lead."""
    lead_alpha = p.lead_alpha if alpha is None else alpha
    pi = control.tf([p.proportional_gain, p.integral_gain], [1.0, 0.0])
    lead = control.tf([p.lead_time, 1.0], [lead_alpha * p.lead_time, 1.0])
    return pi * lead


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


def figures(loop: control.TransferFunction) -> Loop:
    """Margins, bandwidth, peak of H and dip of S."""
    top = 0.999 * np.pi / loop.dt if loop.dt else 1e3
    omega = np.logspace(-2, np.log10(top), 200_001)
    response = loop(np.exp(1j * omega * loop.dt) if loop.dt else 1j * omega)
    hz = omega / (2.0 * np.pi)
    phase = np.unwrap(np.angle(response))
    last = int(np.flatnonzero(np.abs(response) > 1.0)[-1])
    beyond = np.flatnonzero((phase[:-1] > -np.pi) & (phase[1:] <= -np.pi))
    h = np.abs(response / (1.0 + response))
    s = np.abs(1.0 / (1.0 + response))
    over = np.flatnonzero(h > 10.0 ** (-3.0 / 20.0))
    top_of_h = int(np.argmax(h))
    # S falls again towards zero frequency: the dip is the local minimum next to the crossover
    falling: np.ndarray = np.flatnonzero((s[1:-1] < s[:-2]) & (s[1:-1] < s[2:])) + 1
    dips: np.ndarray = falling[falling < last]
    return Loop(
        phase_margin=float(180.0 + np.degrees(phase[last])),
        crossover=float(hz[last]),
        gain_margin=float(1.0 / np.abs(response[beyond[0]])) if beyond.size else np.inf,
        bandwidth=float(hz[over[-1]]),
        peak=float(20.0 * np.log10(h[top_of_h])),
        peak_at=float(hz[top_of_h]),
        dip_at=float(hz[dips[-1]]) if dips.size else np.nan,
    )


def settling_time(loop: control.TransferFunction, band: float = 0.005) -> float:
    """Time after which the step response of H stays within `band` of its final value [s]."""
    t = np.arange(0.0, 120.0, 0.002)
    _, y = control.step_response(control.feedback(loop, 1), t)
    outside = np.flatnonzero(np.abs(np.asarray(y) - 1.0) > band)
    return float(t[outside[-1] + 1])
