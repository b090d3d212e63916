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


@pytest.mark.parametrize(
    ("rate", "timeout_ms", "age", "braking"),
    [(250, 44, 11, 62), (1000, 44, 44, 250), (250, 3, 1, 62), (250, 8, 2, 62), (500, 7, 3, 125)],
)
def test_ages_and_braking_in_cycles(rate, timeout_ms, age, braking) -> None:
    """A command lives at least one cycle; a quick stop lasts a quarter of a second."""
    guard = Guard(rate, timeout_ms)
    assert (guard.timeout, guard.braking) == (age, braking)
    step(guard, 1)
    words = [step(guard, c, health=Health.LOST) for c in range(2, 2 * braking)]
    assert words.count(0x02) == braking and set(words[braking:]) == {0x00}
    fresh = Guard(rate, timeout_ms)
    assert step(fresh, 100, answers=100 - age) == RUN
    assert step(fresh, 101, answers=100 - age) == 0x02


HELD = {
    0x00: (), 0x40: (0x06, 0x07, 0x0F), 0x60: (0x06, 0x07, 0x0F), 0x21: (0x07, 0x0F),
    0x23: (0x0F,), 0x27: "all", 0x07: "all", 0x0F: "all", 0x08: "all", 0x28: "all",
}  # fmt: skip
"""status -> control words that a fault of the bench latches"""


@pytest.mark.parametrize("status", HELD, ids=hex)
@pytest.mark.parametrize("word", [0x00, 0x02, 0x06, 0x07, 0x0F, 0x1F, 0x86], ids=hex)
def test_what_a_fault_latches(status, word) -> None:
    """An energised or faulty drive always, and every step towards motion."""
    guard = Guard(250, 44)
    held = HELD[status] == "all" or (word & 0x0F) in HELD[status]
    inputs = image(0x0210 | status, digital=0)
    assert step(guard, 1, word, inputs=inputs) == (0x02 if held else 0x00)
    assert guard.latched == ({0: Cause.EMERGENCY_STOP} if held else {})


def test_the_reset_of_the_first_cycle_is_no_fresh_one() -> None:
    guard = Guard(250, 44)
    guard.hold_all(0, Cause.BUS)
    assert step(guard, 1, 0x80) == 0x02 and step(guard, 2, 0x80) == 0x02
    assert step(guard, 3, 0x00) == 0x02 and step(guard, 4, 0x80) == 0x80


def test_each_axis_is_held_and_lifted_by_itself() -> None:
    guard = prepared()
    old = {0: command(RUN, 2, 0), 1: command(RUN, -100, 1)}
    assert [c.control_word for c in guard.step(2, old, image(), Health.OK)] == [RUN, 0x02]
    guard.hold_all(3, Cause.BUS)
    assert guard.latched == {0: Cause.BUS, 1: Cause.STALE_COMMAND} | dict.fromkeys(
        (2, 3, 4), Cause.BUS
    )
    assert guard.stops == {"STALE_COMMAND": 1, "BUS": 4}
    for cycle, word in ((4, 0x00), (5, 0x80)):
        asked = {0: command(word, cycle, 0), 1: command(0x00, cycle, 1)}
        out = [c.control_word for c in guard.step(cycle, asked, image(), Health.OK)]
    assert out == [0x80, 0x02] and set(guard.latched) == {1, 2, 3, 4}


def test_a_held_drive_keeps_its_own_error_code() -> None:
    guard = prepared()
    step(guard, 2, health=Health.LOST)
    own = axis()._replace(error_code=0x2310)
    shown = guard.with_held_axes_in_fault(image()._replace(axes=(own,) * len(AXES)))
    assert [a.error_code for a in shown.axes] == [0x2310] * len(AXES)
    assert guard.with_held_axes_in_fault(image()).axes[0].error_code == Cause.BUS
    assert Guard(250, 44).with_held_axes_in_fault(inputs := image()) is inputs


def test_a_limit_switch_that_was_closed_before_the_image_was_lost_is_no_new_edge() -> None:
    closed = image(digital=Digital.EMERGENCY_STOP_OK | Digital.LIMIT_FRONT)
    guard = Guard(250, 44)
    assert step(guard, 1, inputs=closed) == RUN  # nothing is known of before
    assert step(guard, 2, 0x00, inputs=None) == 0x02
    step(guard, 3, 0x00, inputs=closed)
    assert step(guard, 4, 0x80, inputs=closed) == 0x80 and step(guard, 5, inputs=closed) == RUN
