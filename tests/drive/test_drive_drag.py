# SPDX-License-Identifier: Apache-2.0
"""A wheel that is stopped under a moving plank: the plank's drive stops too, else it is told."""

from __future__ import annotations

import pytest
from drive_rig import WORDS, Rig, up

from flatplank_data.params import load_parameters
from flatplank_hw.bus.image import BusInputs
from flatplank_hw.cia402 import QUICK_STOP, State
from flatplank_hw.drive.safety import RULES
from flatplank_hw.share import config_file

PLANK = load_parameters(config_file("flatplank_hw", "plank_drive.yaml"), "plank_drive")
SPEED = 0.03


class PlankRig(Rig):
    """The plank's drive; `wheel` is the state that the wheel's drive shows on the bus."""

    wheel = State.SWITCH_ON_DISABLED

    def image(self, n: int, stamp: int) -> BusInputs:
        image = super().image(n, stamp)
        axes = list(image.axes)
        axes[0] = axes[0]._replace(status_word=WORDS[self.wheel])
        return image._replace(axes=tuple(axes))


def pushing(wheel: State = State.OPERATION_ENABLED) -> PlankRig:
    """The plank driven forward under a loaded tire."""
    rig = PlankRig(**PLANK)
    rig.wheel = wheel
    rig.load()
    rig.run(2)
    rig.drive.set_operation_mode("velocity", 0.0)
    assert rig.drive.enable().accepted
    rig.run(20, until=lambda s: s.state == State.OPERATION_ENABLED)
    assert rig.drive.set_operation_mode("velocity", SPEED).accepted
    rig.plank(True)
    rig.run(100)
    assert rig.velocity == pytest.approx(SPEED, rel=1e-3)
    return rig


@pytest.mark.parametrize("state", [State.QUICK_STOP_ACTIVE, State.FAULT, State.SWITCH_ON_DISABLED])
def test_the_plank_stops_with_the_wheel(state):
    rig = pushing()
    rig.wheel = state
    sample = rig.run(5)
    assert sample.stop_reason == RULES["wheel_stopped"].code
    assert rig.velocity == 0.0 and QUICK_STOP in [c.control_word for c in rig.commands[-5:]]
    assert "wheel_stopped" in rig.drive.troubles
    rig.wheel = State.OPERATION_ENABLED
    rig.run(100)
    assert rig.velocity == 0.0, "nothing starts by itself"
    assert rig.drive.enable().accepted


def test_a_plank_may_go_on_under_a_tire_that_hangs_free():
    rig = pushing()
    rig.fz, rig.radius = 0.0, 0.325
    rig.wheel = State.SWITCH_ON_DISABLED
    rig.run(50)
    assert rig.velocity == pytest.approx(SPEED, rel=1e-3)


def test_a_wheel_that_was_never_driven_is_the_operators_decision():
    rig = pushing(wheel=State.SWITCH_ON_DISABLED)
    assert rig.run(50).stop_reason == 0
    assert rig.velocity == pytest.approx(SPEED, rel=1e-3)


def test_a_stopped_wheel_under_the_switchs_plank_is_an_alarm_until_the_plank_rests():
    rig = up("slip")
    rig.load()
    rig.reference = 0.1
    rig.run(5)
    rig.plank(True)
    rig.run(100)
    assert not rig.drive.troubles
    rig.hub_alive = False
    rig.run(20)
    told = rig.drive.troubles
    assert set(told) == {"samples", "drag"}
    assert "Fz 3700 N" in told["drag"] and "30.9 mm/s" in told["drag"]
    rig.plank(False)
    rig.run(2)
    assert set(rig.drive.troubles) == {"samples"}


def test_no_alarm_while_the_drive_holds_a_locked_wheel_on_purpose():
    rig = up("position")
    rig.load()
    rig.plank(True)
    rig.run(20)
    assert not rig.drive.troubles
