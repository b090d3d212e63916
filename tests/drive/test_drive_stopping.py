# SPDX-License-Identifier: Apache-2.0
"""Stops that the drive does not answer, and enables while it has not."""

from __future__ import annotations

import pytest
from slow_motor import SPEED, rolling

from flatplank_hw.bus.image import Health
from flatplank_hw.cia402 import State
from flatplank_hw.drive.safety import RULES


def test_a_drive_that_does_not_stop_gets_no_commands_any_more():
    """The commands keep the number of an old cycle: the plant's watchdog and the guard act."""
    rig = rolling()
    rig.run(100)
    rig.deaf = True
    rig.drive.quick_stop()
    rig.run(60)
    assert not rig.drive.does_not_stop
    assert rig.commands[-1].cycle == rig.n - 1
    rig.run(40)
    assert rig.drive.does_not_stop
    assert rig.commands[-1].cycle == rig.commands[-20].cycle
    assert "does_not_stop" in rig.drive.troubles
    rig.deaf = False
    rig.state = State.FAULT
    rig.run(5)
    assert not rig.drive.does_not_stop
    assert rig.commands[-1].cycle == rig.n - 1


@pytest.mark.parametrize("again", [0, 30, 55])
def test_a_stop_that_the_drive_has_not_answered_outlasts_an_enable(again):
    """Enabled again, a deaf drive had the whole time of the following error once more."""
    rig = rolling()
    rig.run(100)
    rig.deaf = True
    rig.drive.disable()
    for _ in range(again):
        rig.cycle()
    assert rig.drive.enable().accepted
    rig.run(60 - again)
    assert not rig.drive.does_not_stop
    rig.run(5)
    assert rig.drive.does_not_stop
    assert rig.commands[-1].cycle < rig.n - 1


def test_a_drive_that_is_enabled_at_once_after_a_stop_leaves_operation_first():
    rig = rolling()
    rig.run(100)
    rig.drive.disable()
    assert rig.drive.enable().accepted
    rig.run(50)
    states = [sample.state for sample in rig.samples[-50:]]
    assert {sample.stop_reason for sample in rig.samples[-50:]} == {0}
    assert State.QUICK_STOP_ACTIVE in states
    assert states[-1] is State.OPERATION_ENABLED
    assert rig.velocity == pytest.approx(SPEED, rel=1e-6)


def test_rules_apply_while_an_enable_waits_for_the_answer_to_a_stop():
    rig = rolling()
    rig.run(100)
    rig.deaf = True
    rig.drive.disable()
    assert rig.drive.enable().accepted
    rig.run(10)
    rig.health = int(Health.LOST)
    rig.run(1)
    assert rig.samples[-1].stop_reason == RULES["inputs"].code
