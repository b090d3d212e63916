# SPDX-License-Identifier: Apache-2.0
"""The guard between the commands and the wire: every cause, what it latches, what lifts it."""

from __future__ import annotations

import pytest
from ethercat_rig import RUN, axis, command, image

from flatplank_hw.bus.image import AXES, Digital, Health
from flatplank_hw.ethercat.master.guard import Cause, Guard

OFF, SHUTDOWN = 0x0250, 0x06


def step(guard: Guard, cycle: int, word: int = RUN, **facts) -> int:
    """Control word that goes out for the wheel."""
    inputs = facts.get("inputs", image())
    asked = {0: command(word, facts.get("answers", cycle))}
    return guard.step(cycle, asked, inputs, facts.get("health", Health.OK))[0].control_word


BAD = [
    ({"health": Health.LOST}, Cause.BUS),
    ({"health": Health.STALE}, Cause.BUS),
    ({"health": Health.SLAVE_FAULT}, Cause.BUS),
    ({"inputs": image(digital=0)}, Cause.EMERGENCY_STOP),
    ({"answers": -100}, Cause.STALE_COMMAND),
    (
        {"inputs": image(digital=Digital.EMERGENCY_STOP_OK | Digital.LIMIT_FRONT)},
        Cause.LIMIT_SWITCH,
    ),
]


def prepared() -> Guard:
    guard = Guard(250, 44)
    assert step(guard, 1) == RUN
    return guard


def test_every_cause_is_tried() -> None:
    assert {cause for _, cause in BAD} == set(Cause) - {Cause.NONE}


@pytest.mark.parametrize(("facts", "cause"), BAD, ids=lambda v: getattr(v, "name", ""))
def test_every_cause_stops_and_stays(facts: dict, cause: Cause) -> None:
    guard = prepared()
    assert step(guard, 2, **facts) == 0x02
    assert guard.latched == {0: cause} and guard.stops == {cause.name: 1}
    assert all(step(guard, c) == 0x02 for c in range(3, 60))
    assert all(step(guard, c) == 0x00 for c in range(65, 90)), "the voltage goes after a while"
    shown = guard.with_held_axes_in_fault(image()).axes[0]
    assert (shown.status_word & 0x4F, shown.error_code) == (0x08, int(cause))
    assert guard.with_held_axes_in_fault(image()).axes[1] == axis()


@pytest.mark.parametrize(("facts", "cause"), BAD, ids=lambda v: getattr(v, "name", ""))
def test_only_a_fresh_reset_lifts_a_stop(facts: dict, cause: Cause) -> None:
    guard = prepared()
    step(guard, 2, **facts)
    if cause != Cause.LIMIT_SWITCH:
        assert step(guard, 3, 0x80, **facts) == 0x02, "the cause is still there"
        assert step(guard, 4, 0x80) == 0x02, "the bit has been up before the cause went"
    assert step(guard, 5, SHUTDOWN) == 0x02
    assert step(guard, 6, 0x80) == 0x80 and not guard.latched
    assert step(guard, 7, RUN) == RUN


def test_degraded_is_no_cause() -> None:
    guard = prepared()
    assert all(step(guard, c, health=Health.DEGRADED) == RUN for c in range(2, 20))


def test_command_age() -> None:
    guard = prepared()
    assert guard.timeout == 11
    assert step(guard, 12, answers=1) == RUN
    assert step(guard, 13, answers=1) == 0x02


def test_an_idle_axis_is_not_latched() -> None:
    """Nothing turned and nothing was asked: once the bus is well, a fresh enable may pass."""
    guard = Guard(250, 44)
    off = image(OFF)
    assert step(guard, 1, 0x00, inputs=off, health=Health.LOST) == 0x00 and not guard.latched
    assert step(guard, 2, SHUTDOWN, inputs=off) == SHUTDOWN


@pytest.mark.parametrize("fault", [0x0218, 0x0238, 0x021F], ids=["rests", "quick stop", "brakes"])
@pytest.mark.parametrize(("facts", "cause"), BAD[:3], ids=lambda v: getattr(v, "name", ""))
def test_a_drive_that_forgets_its_fault_while_the_bus_is_bad_stays_held(
    facts: dict, cause: Cause, fault: int
) -> None:
    """It restarts, and may be enabled: only a reset by the operator lets it."""
    guard = prepared()
    for cycle, word in enumerate((0x00, SHUTDOWN, RUN), 2):
        assert step(guard, cycle, word, inputs=image(fault), **facts) == 0x02
    assert guard.latched == {0: cause}
    assert all(step(guard, c, SHUTDOWN, inputs=image(OFF)) == 0x02 for c in range(5, 20))
    assert step(guard, 20, 0x80, inputs=image(OFF)) == 0x80
    assert step(guard, 21, SHUTDOWN, inputs=image(OFF)) == SHUTDOWN


def test_an_enable_asked_during_a_fault_is_latched() -> None:
    guard = Guard(250, 44)
    assert step(guard, 1, SHUTDOWN, inputs=image(OFF), health=Health.LOST) == 0x02
    assert guard.latched == {0: Cause.BUS}


def test_nothing_passes_before_the_first_image() -> None:
    guard = Guard(250, 44)
    assert step(guard, 1, inputs=None) == 0x02


def test_limit_switch_counts_by_its_edge_and_for_its_axes() -> None:
    closed = image(digital=Digital.EMERGENCY_STOP_OK | Digital.LIMIT_FRONT)
    guard = prepared()
    asked = {n: command(RUN, 2, n) for n in range(len(AXES))}
    words = [c.control_word for c in guard.step(2, asked, closed, Health.OK)]
    assert words == [0x02, 0x02, RUN, RUN, RUN]
    step(guard, 3, 0x00, inputs=closed)
    assert step(guard, 4, 0x80, inputs=closed) == 0x80
    assert step(guard, 5, RUN, inputs=closed) == RUN, "the way back must be open"
    rear = image(digital=Digital.EMERGENCY_STOP_OK | Digital.LIMIT_REAR)
    assert [c.control_word for c in prepared().step(2, asked, rear, Health.OK)][:2] == [RUN, 0x02]


def test_held_axes_have_no_targets() -> None:
    guard = prepared()
    out = guard.step(2, {0: command(RUN, 2)}, image(), Health.LOST)[0]
    assert (out.target_velocity, out.target_torque, out.digital_outputs) == (0, 0, 0)


def test_end_of_the_bus_holds_everything() -> None:
    guard = prepared()
    guard.hold_all(2, Cause.STALE_COMMAND)
    assert step(guard, 2) == 0x02 and set(guard.latched) == set(range(len(AXES)))
