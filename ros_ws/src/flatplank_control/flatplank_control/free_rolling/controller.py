# SPDX-License-Identifier: Apache-2.0
"""The free-rolling controller (5.10)-(5.12): computes the motor torque for a small longitudinal
force."""

from __future__ import annotations

import math
from typing import NamedTuple

from flatplank_control.free_rolling.design import Gains, design_gains
from flatplank_control.free_rolling.params import FreeRollingParameters
from flatplank_control.free_rolling.start import OVER, UNKNOWN, Start, Tire
from flatplank_data.limits import FORCE
from flatplank_hw.samples import EncoderSample, HubSample, Reference

SOURCE = "free_rolling"
_BACKWARDS = -0.0005
"""the plank moves backward below this velocity [m/s]"""


class ControllerState(NamedTuple):
    """State of the controller after a step."""

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
    """PI and lead compensator, discretized by the bilinear rule (Tustin); reset each time the
    plank starts or stops."""

    def __init__(self, p: FreeRollingParameters) -> None:
        self.parameters = p
        self._smooth = -math.expm1(-1.0 / (p.settled_filter * p.rate_hz))
        self._band = p.settled_band * abs(p.reference)
        self._running = False
        self._output = 0.0
        self._needed = round(p.settled_time * p.rate_hz)
        self.reset()

    @property
    def gains(self) -> Gains:
        """Gains in use: those of the parameters until a start has estimated others."""
        return self._gains

    @property
    def tire(self) -> Tire:
        """Tire estimate of the last start, in automatic mode."""
        return self._tire

    def _set_gains(self, gains: Gains) -> None:
        rate = self.parameters.rate_hz
        self._gains = gains
        zero, pole = 2.0 * gains.lead_time * rate, 2.0 * gains.lead_alpha * gains.lead_time * rate
        self._b0, self._b1 = (1.0 + zero) / (1.0 + pole), (1.0 - zero) / (1.0 + pole)
        self._a1 = (1.0 - pole) / (1.0 + pole)
        self._half = 0.5 * gains.integral / rate

    @property
    def state(self) -> ControllerState:
        """State after the last step."""
        return ControllerState(
            self.parameters.reference, self._error, self._p, self._i, self._lead, self._output,
            self._saturated, self._inside > self._needed,
        )  # fmt: skip

    def step(self, hub: HubSample, encoders: EncoderSample) -> Reference:
        """Torque reference of this cycle [N m at the motor]; takes about 2 us."""
        fx = hub.contact.fx
        valid = FORCE.admits(fx)
        running = encoders.plank_moving and encoders.plank_velocity > _BACKWARDS
        if running != self._running:
            self.reset()
            self._running = running
        if running and valid:
            start = self._start
            if start is not None and start.phase != OVER:
                self._begin(start, fx, encoders)
            else:
                if start is not None and start.tire is None:
                    self._retune_from_estimate(start, fx, encoders)
                self._advance(self.parameters.reference - fx)
        return Reference(hub.cycle, hub.stamp_ns, SOURCE, self._output, valid)

    def reset(self) -> None:
        """Reset to the state before the plank moves."""
        self._running = False
        self._error = self._p = self._i = self._lead = self._output = 0.0
        self._pi_before = self._error_before = 0.0
        self._slow_error, self._inside, self._saturated = self.parameters.reference, 0, False
        p = self.parameters
        self._tire = UNKNOWN
        self._start = Start(p) if p.automatic else None
        self._set_gains(Gains(p.proportional_gain, p.integral_gain, p.lead_time, p.lead_alpha))

    def _begin(self, start: Start, fx: float, encoders: EncoderSample) -> None:
        """Command the torque of the start; at its end the force loop continues without a jump."""
        p = self.parameters
        self._output = start.step(fx, encoders)
        if start.phase != OVER:
            return
        stiffness = start.stiffness if start.stiffness > 0.0 else p.stiffest
        self._tire = Tire(stiffness, math.nan, math.nan)
        self._set_gains(design_gains(stiffness, math.inf, p.loop_delay))
        self._error = self._error_before = p.reference - fx
        self._p = self._gains.proportional * self._error
        self._i = start.torque - p.start_torque - self._p
        self._pi_before = self._lead = self._p + self._i

    def _retune_from_estimate(self, start: Start, fx: float, encoders: EncoderSample) -> None:
        """Set the gains from the estimate over the first centimetres, without a jump of the
        torque."""
        start.observe(fx, encoders)
        tire = start.tire
        if tire is None or not tire.stiffness > 0.0:
            return
        self._tire = tire
        before = self._lead
        self._set_gains(design_gains(tire.stiffness, tire.relaxation, self.parameters.loop_delay))
        self._p = self._gains.proportional * self._error
        self._i = before - self._p
        self._pi_before = self._lead = before

    def _advance(self, error: float) -> None:
        p = self.parameters
        integral = self._i + self._half * (error + self._error_before)
        proportional = self._gains.proportional * error
        pi = proportional + integral
        lead = self._b0 * pi + self._b1 * self._pi_before - self._a1 * self._lead
        wanted = lead + p.start_torque
        output = min(max(wanted, p.torque_min), p.torque_max)
        excess = wanted - output
        if excess * error > 0.0:
            # anti-windup: do not integrate further into the limit
            integral = self._i
            pi = proportional + integral
        self._error, self._error_before = error, error
        self._p, self._i, self._lead = proportional, integral, lead
        self._pi_before, self._output, self._saturated = pi, output, excess != 0.0
        self._slow_error += self._smooth * (error - self._slow_error)
        inside = -self._band <= self._slow_error <= self._band
        self._inside = self._inside + 1 if inside else 0
