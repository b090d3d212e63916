# SPDX-License-Identifier: Apache-2.0
"""The free-rolling controller (5.10)-(5.12): motor torque that holds a small longitudinal
force."""

from __future__ import annotations

import math
from typing import NamedTuple

from flatplank_control.free_rolling.params import FreeRollingParameters
from flatplank_hw.samples import EncoderSample, HubSample, Reference

SOURCE = "free_rolling"
_BACKWARDS = -0.0005
"""A plank slower than this goes back [m/s]."""


class ControllerState(NamedTuple):
    """Inside of the controller after a step."""

    reference: float
    """[N]"""
    error: float
    """[N]"""
    p: float
    """[N m]"""
    i: float
    """[N m]"""
    lead: float
    """PI after the lead compensator [N m]"""
    output: float
    """with start torque, limited [N m]"""
    saturated: bool
    settled: bool


class FreeRollingController:
    """PI, then lead, both by the bilinear rule; starts from zero each time the plank starts."""

    def __init__(self, p: FreeRollingParameters) -> None:
        self.parameters = p
        period = 1.0 / p.rate_hz
        zero, pole = 2.0 * p.lead_time * p.rate_hz, 2.0 * p.lead_alpha * p.lead_time * p.rate_hz
        self._b0, self._b1 = (1.0 + zero) / (1.0 + pole), (1.0 - zero) / (1.0 + pole)
        self._a1 = (1.0 - pole) / (1.0 + pole)
        self._half = 0.5 * p.integral_gain * period
        self._smooth = -math.expm1(-period / p.settled_filter)
        self._band = p.settled_band * abs(p.reference)
        self._running = False
        self._output = 0.0
        self._needed = round(p.settled_time * p.rate_hz)
        self.reset()

    @property
    def state(self) -> ControllerState:
        """What the last step did."""
        return ControllerState(
            self.parameters.reference, self._error, self._p, self._i, self._lead, self._output,
            self._saturated, self._inside > self._needed,
        )  # fmt: skip

    def step(self, hub: HubSample, encoders: EncoderSample) -> Reference:
        """Torque reference of this cycle [N m at the motor]; about 2 us."""
        fx = hub.contact.fx
        valid = -1e6 < fx < 1e6
        running = encoders.plank_moving and encoders.plank_velocity > _BACKWARDS
        if running != self._running:
            self.reset()
            self._running = running
        if running and valid:
            self._advance(self.parameters.reference - fx)
        return Reference(hub.cycle, hub.stamp_ns, SOURCE, self._output, valid)

    def reset(self) -> None:
        """Start from zero, as if the plank had not moved yet."""
        self._running = False
        self._error = self._p = self._i = self._lead = self._output = 0.0
        self._pi_before = self._error_before = 0.0
        self._slow_error, self._inside, self._saturated = self.parameters.reference, 0, False

    def _advance(self, error: float) -> None:
        p = self.parameters
        integral = self._i + self._half * (error + self._error_before)
        proportional = p.proportional_gain * error
        pi = proportional + integral
        lead = self._b0 * pi + self._b1 * self._pi_before - self._a1 * self._lead
        wanted = lead + p.start_torque
        output = min(max(wanted, p.torque_min), p.torque_max)
        excess = wanted - output
        if excess * error > 0.0:
            # anti-windup: a step that would only push further into the limit is not integrated
            integral = self._i
            pi = proportional + integral
        self._error, self._error_before = error, error
        self._p, self._i, self._lead = proportional, integral, lead
        self._pi_before, self._output, self._saturated = pi, output, excess != 0.0
        self._slow_error += self._smooth * (error - self._slow_error)
        inside = -self._band <= self._slow_error <= self._band
        self._inside = self._inside + 1 if inside else 0
