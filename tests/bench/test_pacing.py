# SPDX-License-Identifier: Apache-2.0
"""When the simulated bus makes a cycle: wall time is an argument."""

from types import SimpleNamespace

import pytest

from flatplank_hw.bus.commanders import CommandGate
from flatplank_hw.bus.histogram import percentile
from flatplank_hw.bus.image import AxisCommand
from flatplank_hw.bus.pacing import ABSENT_TIMEOUT_S, CATCH_UP, Pacer
from flatplank_hw.bus.timing import LATE, MADE, REMEMBERED, BusTiming
from flatplank_hw.nodes import exchanges
from flatplank_hw.nodes.convert import StampedCommand
from flatplank_msgs.msg import BusOutputs
from flatplank_sim.nodes.simulated_plant import SimulatedPlant

RATE = 250.0


def lockstep(axes=frozenset({0})):
    return Pacer("lockstep", 1, axes, timeout=1.0)


def test_lockstep_goes_on_when_all_axes_have_answered_the_last_cycle():
    pacer = lockstep(frozenset({0, 1}))
    pacer.register_batch(1, wall=0.0)
    assert not pacer.register_answer(0)
    assert pacer.register_answer(1)


def plant_at(cycle: int, stamp_ns: int) -> SimpleNamespace:
    """What `SimulatedPlant.on_command` uses, after the inputs of a cycle."""
    gate, pacer = CommandGate(), lockstep()
    gate.send(stamp_ns)
    pacer.register_batch(cycle, wall=0.0)
    return SimpleNamespace(
        commands={}, ages=[0] * 64, timing=BusTiming(), cycle=cycle, pacer=pacer, gate=gate,
        release=lambda: None, idle=lambda: True,
    )  # fmt: skip


def answer(stamp_ns: int, cycle: int) -> StampedCommand:
    return StampedCommand(stamp_ns, AxisCommand(0, cycle, 0, 0, 0, 0, 0, 0))


def test_an_answer_to_older_inputs_does_not_count():
    plant = plant_at(cycle=2, stamp_ns=20)
    SimulatedPlant.on_command(plant, answer(stamp_ns=10, cycle=1))
    assert plant.pacer.missing == {0}
    SimulatedPlant.on_command(plant, answer(stamp_ns=20, cycle=2))
    assert not plant.pacer.missing


def test_a_drive_that_does_not_stop_does_not_hold_the_bus():
    """Its commands keep the number of an old cycle, so that the watchdog of the drive acts."""
    plant = plant_at(cycle=300, stamp_ns=20)
    SimulatedPlant.on_command(plant, answer(stamp_ns=20, cycle=7))
    assert not plant.pacer.missing


def test_a_command_of_the_bus_before_a_clean_up_is_dropped():
    """Configured again, the plant has made no cycle yet; it would wait for cycle 500."""
    plant = plant_at(cycle=-1, stamp_ns=0)
    for cycle in (500, 5):
        old = exchanges.COMMAND.read(BusOutputs(axis=0, cycle=cycle))
        SimulatedPlant.on_command(plant, old)
    assert not plant.commands and not any(plant.ages)


def test_lockstep_waits_for_a_late_node_however_long_and_says_so():
    pacer = lockstep()
    pacer.register_answer(0)
    pacer.register_batch(1, wall=10.0)
    assert pacer.batches_due(500.0, RATE) == 0
    assert pacer.waited(10.9) == 0.0 and pacer.waited(500.0) == 490.0
    assert pacer.register_answer(0)
    assert pacer.waited(500.0) == 0.0 and not pacer.absent


@pytest.mark.parametrize("begin", ["its first answer is lost", "it leaves"])
def test_for_a_node_that_is_not_there_lockstep_waits_once_and_then_no_longer_than_a_period(begin):
    pacer = lockstep()
    if begin == "it leaves":
        pacer.register_answer(0)
    pacer.register_batch(1, wall=10.0)
    if begin == "it leaves":
        assert pacer.batches_due(500.0, RATE) == 0
        pacer.register_leaving()
    assert pacer.batches_due(10.5, RATE) == 0
    assert pacer.batches_due(11.0, RATE) == 1
    pacer.register_batch(2, wall=11.0)
    assert pacer.batches_due(11.0 + 0.9 / RATE, RATE) == 0
    assert pacer.batches_due(11.0 + 1.1 / RATE, RATE) == 1
    pacer.advance(2, 100)  # somebody waits for these cycles
    assert pacer.batches_due(11.0 + ABSENT_TIMEOUT_S, RATE) == 1
    pacer.register_batch(3, wall=11.01)
    assert pacer.register_answer(0)
    pacer.register_batch(4, wall=11.02)
    assert pacer.batches_due(11.5, RATE) == 0


def test_a_node_that_leaves_between_two_cycles_is_not_waited_for():
    pacer = lockstep()
    pacer.register_batch(1, wall=10.0)
    assert pacer.register_answer(0)
    pacer.register_leaving()
    pacer.register_batch(2, wall=10.1)
    assert pacer.batches_due(11.1, RATE) == 1


def test_idle_lockstep_is_no_faster_than_the_clock():
    pacer = lockstep()
    pacer.register_batch(1, wall=10.0)
    pacer.register_answer(0)
    assert pacer.batches_due(10.0 + 0.9 / RATE, RATE, idle=True) == 0
    assert pacer.batches_due(10.0 + 1.1 / RATE, RATE, idle=True) == 1
    assert pacer.batches_due(10.0 + 0.1 / RATE, RATE, idle=False) == 1


def test_a_tick_that_is_earlier_than_the_first_was_is_not_left_to_the_next():
    """The first tick came late, by a quarter of a period, and all others in time."""
    pacer = Pacer("realtime", 1, frozenset(), timeout=1.0)
    pacer.set_pace("realtime", 9.9985)  # at any time between two ticks
    made = []
    for cycle, wall in enumerate([10.001, *(10.0 + k / RATE for k in range(1, 50))]):
        made.append(pacer.batches_due(wall, RATE))
        for _ in range(made[-1]):
            pacer.register_batch(cycle, wall)
    assert made == [0] + [1] * 49


def test_durations_of_a_bus_are_told_in_microseconds():
    timing = BusTiming()
    for cycle in range(1000):
        timing.add_wake_up(50_000 if cycle else 2_000_000)
        timing.add_frame(cycle, 1, (1 + cycle) * 4_000_000)
        timing.add_command(cycle, now_ns=(1 + cycle) * 4_000_000 + 300_000)
        timing.add_command(cycle - REMEMBERED, now_ns=0)  # too old to be timed
    timing.late += 10
    told = timing.values()
    assert (told[MADE], told[LATE]) == (1000, 10)
    assert told["wake-up p99 [us]"] == pytest.approx(50.0, rel=0.1)
    assert told["wake-up p99.9 [us]"] == pytest.approx(50.0, rel=0.1)
    assert told["wake-up worst [us]"] == 2000.0
    assert told["frame to frame worst [us]"] == 4000.0
    assert told["stamp to command p50 [us]"] == pytest.approx(300.0, rel=0.1)


def test_hold_makes_no_cycle_and_advance_makes_just_as_many_as_asked():
    pacer = Pacer("hold", 1, frozenset({0}), timeout=1.0)
    assert pacer.batches_due(100.0, RATE) == 0
    until = pacer.advance(0, 3)
    made = 0
    while pacer.all_have_answered():
        made += 1
        pacer.register_batch(made, wall=0.0)
        pacer.register_answer(0)
    assert made == until == 3
    assert pacer.pace == "hold"


def test_who_asks_for_less_does_not_end_what_another_asked_for():
    pacer = Pacer("hold", 1, frozenset({0}), timeout=1.0)
    assert pacer.advance(0, 5) == 5
    assert pacer.advance(0, 2) == 2
    for cycle in range(1, 5):
        pacer.register_batch(cycle, wall=0.0)
        assert pacer.pace == "lockstep"
    pacer.register_batch(5, wall=0.0)
    assert pacer.pace == "hold"


def test_a_held_bus_gives_up_on_a_drive_that_has_gone():
    pacer = Pacer("hold", 1, frozenset({0}), timeout=1.0)
    pacer.advance(0, 2)
    for cycle in (1, 2):
        pacer.register_answer(0)
        pacer.register_batch(cycle, wall=5.0)
    assert not pacer.stop_waiting(50.0)
    pacer.register_leaving()
    assert not pacer.stop_waiting(5.9)
    assert pacer.stop_waiting(6.0)
    assert not pacer.missing


def test_realtime_makes_what_the_clock_asks_for():
    pacer = Pacer("realtime", 1, frozenset({0}), timeout=1.0)
    assert pacer.batches_due(50.0, RATE) == 0
    assert pacer.batches_due(50.0 + 3.4 / RATE, RATE) == 3
    for cycle in (1, 2, 3):
        pacer.register_batch(cycle, 50.0)
    assert pacer.batches_due(50.0 + 3.4 / RATE, RATE) == 0


def test_realtime_that_was_held_up_for_long_says_what_it_dropped():
    pacer = Pacer("realtime", 1, frozenset({0}), timeout=1.0)
    pacer.batches_due(0.0, RATE)
    assert pacer.batches_due(1.0, RATE) == CATCH_UP
    assert pacer.skipped == 250 - CATCH_UP


def test_an_unknown_pace_is_refused():
    with pytest.raises(ValueError, match="unknown 'fast'"):
        Pacer("fast", 1, frozenset(), 1.0)


def test_a_percentile_of_counts():
    assert percentile([98, 1, 1], 0.98) == 0
    assert percentile([98, 1, 1], 0.99) == 1
    assert percentile([0, 0, 3], 0.5) == 2
    assert percentile([0, 0], 0.99) == 0
