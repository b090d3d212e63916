# SPDX-License-Identifier: Apache-2.0
"""Controller of the vertical force on a driven vertical axis; off by default.

It commands the axle speed from the error of Fz. The tire acts as a spring and the axis integrates,
so P and a little I suffice."""

from __future__ import annotations

import math
from dataclasses import dataclass

from flatplank_data.limits import FORCE, LIMITS, Limit
from flatplank_data.params import Params, param
from flatplank_hw.samples import FOLLOW, EncoderSample, HubSample, Reference


@dataclass(frozen=True)
class LoadParameters(Params):
    """Parameters of the load controller. The gain is the crossover over C_z."""

    enabled: bool = param(True, "hold Fz instead of the axle's height")
    rate_hz: float = param(250.0, "bus rate", unit="Hz", bounds=(10.0, 4000.0))
    vertical_stiffness: float = param(
        2.13e5, "C_z of the tire, the Toyo's at 2.5 bar, G.2", unit="N/m", bounds=(1e4, 1e7)
    )
    crossover: float = param(10.0, "crossover of the loop", unit="rad/s", bounds=(0.1, 100.0))
    integral_share: float = param(0.15, "zero of the PI over the crossover", bounds=(0.0, 1.0))
    speed_limit: float = param(0.005, "largest speed of the axle", unit="m/s", bounds=(1e-5, 0.1))
    filter_time: float = param(
        0.01, "low-pass of the measured force", unit="s", bounds=(0.001, 1.0)
    )
    ramp: float = param(2000.0, "rate of change to a new set-point", unit="N/s", bounds=(1.0, 1e5))
    fz_limit: float = param(LIMITS["fz"].high, "largest set-point", unit="N", bounds=(0.0, 1e5))


class LoadController:
    """PI controller of Fz; `step` returns the speed of the axle [m/s], positive upwards.

    Two measures avoid overshoot: a ramp of the set-point, and no integration on the ramp and while
    the speed is limited.
    """

    def __init__(self, p: LoadParameters) -> None:
        self.parameters = p
        self._gain = p.crossover / p.vertical_stiffness
        self._rate = p.integral_share * p.crossover / p.rate_hz
        self._smooth = -math.expm1(-1.0 / (p.filter_time * p.rate_hz))
        self.set_point = 0.0
        self._ramp = self._force = math.nan
        self._integral = 0.0

    def set_load(self, fz: float) -> None:
        """Set a new load [N]; ValueError outside 0 .. `fz_limit`."""
        if reason := Limit(0.0, self.parameters.fz_limit, "N").refusal("fz", fz):
            raise ValueError(reason)
        self.set_point = fz

    def reset(self) -> None:
        """Restart the ramp at the present load."""
        self._ramp = self._force = math.nan
        self._integral = 0.0

    def reference(self, hub: HubSample, _encoders: EncoderSample) -> Reference:
        """Set-point of the vertical axis in mode `follow`; not valid while it is off."""
        on = self.parameters.enabled
        speed = self.step(hub)
        return Reference(hub.cycle, hub.stamp_ns, FOLLOW, speed, on and math.isfinite(speed))

    def step(self, hub: HubSample) -> float:
        """Axle speed of this cycle [m/s]; 0 when the controller is off, NaN without a force."""
        p = self.parameters
        if not p.enabled:
            return 0.0
        fz = hub.contact.fz
        if not FORCE.admits(fz):
            return math.nan
        if self._ramp != self._ramp:
            self._ramp = self._force = fz
        self._force += self._smooth * (fz - self._force)
        step = p.ramp / p.rate_hz
        self._ramp += min(max(self.set_point - self._ramp, -step), step)
        error = self._ramp - self._force
        wanted = self._gain * (error + self._integral)
        speed = min(max(wanted, -p.speed_limit), p.speed_limit)
        arrived = self._ramp == self.set_point
        if speed == wanted and arrived:
            self._integral += self._rate * error
        return -speed
