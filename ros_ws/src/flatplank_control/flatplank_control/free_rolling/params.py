# SPDX-License-Identifier: Apache-2.0
"""Parameters of the free-rolling controller; the defaults are (5.10)-(5.12) except for the pole of
the lead."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_data.machine import GEAR_RATIO
from flatplank_data.params import Params, param

THESIS_LEAD_ALPHA = 0.2174
"""alpha_l of (5.11). With two cycles of delay and the zero-order hold at 250 Hz the phase margin
is 28.6 deg."""


@dataclass(frozen=True)
class FreeRollingParameters(Params):
    """PI and lead compensator, start, limits.

    `lead_alpha` is smaller than in the thesis: it moves the pole of the lead away from the
    crossover. This recovers the phase that the real loop delay costs (11.3 deg at 250 Hz) and so
    the 39.9 deg of the design. Set 0.2174 for the controller as printed in the thesis.
    """

    rate_hz: float = param(250.0, "bus rate", unit="Hz", bounds=(10.0, 4000.0))
    reference: float = param(
        50.0, "longitudinal force to be held, thesis 5.5", unit="N", bounds=(-1000.0, 1000.0)
    )
    proportional_gain: float = param(
        5.0e-3, "proportional gain of the PI, (5.10)", unit="N m/N", bounds=(0.0, 1.0)
    )
    integral_gain: float = param(
        5.0e-4, "integral gain of the PI, (5.10)", unit="N m/(N s)", bounds=(0.0, 1.0)
    )
    lead_time: float = param(0.1105, "T_d of (5.11)", unit="s", bounds=(0.0, 10.0))
    lead_alpha: float = param(0.113, "alpha_l of (5.11), thesis 0.2174", bounds=(0.01, 1.0))
    start_torque: float = param(
        2.0, "added once the plank moves, thesis 5.5", unit="N m", bounds=(0.0, 20.0)
    )
    torque_min: float = param(
        -4.0, "lowest output", unit="N m", bounds=(-100.0, 0.0), placeholder=True
    )
    torque_max: float = param(
        8.0, "highest output", unit="N m", bounds=(0.0, 100.0), placeholder=True
    )
    automatic: bool = param(
        True, "estimate the tire in the first millimetres, make up the lost travel, set the gains"
    )
    delay_cycles: float = param(
        2.0, "sample to effect, without the hold, for automatic gains", bounds=(0.0, 20.0)
    )
    stiffest: float = param(
        1.1e6,
        "C_x for the gains when the start measures no tire force",
        unit="N/m",
        bounds=(1e4, 1e8),
    )
    effective_radius: float = param(
        0.3085, "r_e at the start, a guess of 1 % will do", unit="m", bounds=(0.1, 1.0)
    )
    gear_ratio: float = param(GEAR_RATIO, "motor to wheel, 30.32 * 47", bounds=(1.0, 1e6))
    catch_gain: float = param(
        0.05, "start: torque over motor speed error", unit="N m s/rad", bounds=(0.0, 10.0)
    )
    catch_rate: float = param(
        8.0, "start: lost travel made up at this rate", unit="1/s", bounds=(0.0, 100.0)
    )
    caught: float = param(
        0.00015, "start: lost travel that counts as recovered", unit="m", bounds=(1e-6, 0.01)
    )
    settled_band: float = param(
        0.05, "settled: largest filtered error, relative to the reference", bounds=(0.001, 1.0)
    )
    settled_filter: float = param(
        1.0, "settled: time constant of the filter of the error", unit="s", bounds=(0.01, 60.0)
    )
    settled_time: float = param(
        2.0, "settled: time within settled_band", unit="s", bounds=(0.0, 60.0)
    )

    @property
    def loop_delay(self) -> float:
        """Delay from sample to effect, including the hold [s]."""
        return (self.delay_cycles + 0.5) / self.rate_hz
