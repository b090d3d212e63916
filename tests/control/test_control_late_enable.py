# SPDX-License-Identifier: Apache-2.0
"""A wheel that is enabled over a moving road: what it lost while it stood is not recovered."""

from __future__ import annotations

from flatplank_control.bench.setup import BenchSetup
from flatplank_control.sequencer.params import FASTEST
from flatplank_data.machine import GEAR_RATIO, USUAL_RADIUS
from flatplank_hw.troubles import TROUBLES
from flatplank_sim.twin.twin import Twin

STANDS_S = 2.0
"""time for which the wheel stands over the moving road [s]"""


def enabled_late(mode: str, stands: float = STANDS_S) -> Twin:
    """A bench whose wheel has just been enabled after it stood for `stands` [s]."""
    twin = Twin(BenchSetup())
    operator = twin.plant.operator
    operator.load_to(3700.0)
    twin.cycle()
    while not operator.view.at_target:
        twin.cycle()
    assert twin.sequencer.set_waveform("constant", {"kappa": 0.0}, 0.3, USUAL_RADIUS).accepted
    assert twin.drive.set_operation_mode(mode).accepted
    operator.plank(1, fast=True)
    for _ in range(round(stands * twin.rate_hz)):
        twin.cycle()
    assert twin.drive.enable().accepted
    return twin


def fastest_wheel_over_road(mode: str) -> float:
    """Largest speed of the wheel after it is enabled, over that of the free wheel [-]."""
    twin, fastest = enabled_late(mode), 0.0
    for _ in range(round(STANDS_S * twin.rate_hz)):
        encoders = twin.cycle().encoders
        free = encoders.plank_velocity / USUAL_RADIUS
        fastest = max(fastest, encoders.motor_velocity / GEAR_RATIO / free)
    return fastest


def test_the_travel_of_a_disabled_wheel_is_not_recovered():
    assert 1.0 < fastest_wheel_over_road("slip") < 0.5 * (1.0 + FASTEST)


def test_the_force_of_a_disabled_wheel_is_not_integrated():
    """It takes the torque for a wheel that turns faster than the recovery of a start allows."""
    assert 1.0 < fastest_wheel_over_road("free_rolling") < 2.0 * FASTEST


def test_a_stop_of_a_wheel_that_was_enabled_late_says_when_to_enable_it():
    """The wheel is braked for long: it turns faster than a tire rolls, until its force is gone."""
    twin = enabled_late("free_rolling", 6.0)
    for _ in range(round(STANDS_S * twin.rate_hz)):
        twin.cycle()
    told = TROUBLES["following_error"].line(twin.drive.troubles["following_error"])
    assert "enable it before the plank moves" in told
