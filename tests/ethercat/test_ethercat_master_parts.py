# SPDX-License-Identifier: Apache-2.0
"""The pure parts of the master: image, health, recovery, inbox, clock, histogram."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from ethercat_rig import BUS_FILES, command, image

from flatplank_hw.bus.histogram import Histogram
from flatplank_hw.bus.image import AxisCommand, AxisInputs, Digital, Health
from flatplank_hw.ethercat.busfile import BusFile
from flatplank_hw.ethercat.master import link
from flatplank_hw.ethercat.master.health import (
    EFFECT_TIMEOUT_S,
    SETTLE_S,
    CycleObservation,
    HealthMonitor,
    RecoveryPolicy,
    RecoveryStep,
    SlaveState,
)
from flatplank_hw.ethercat.master.image import (
    CounterExtension,
    InputImage,
    OutputImage,
    expected_counter,
    place_bits,
)
from flatplank_hw.ethercat.master.loop import BusLoop, Timing
from flatplank_hw.ethercat.master.pacing import CATCH_UP, CommandInbox, CycleClock
from flatplank_hw.ethercat.reader import BusFileError, read_bus_file

BENCH = read_bus_file(BUS_FILES / "bench.yaml")
PERIOD = 4_000_000


# --- process image ------------------------------------------------------------------------


def test_expected_counter() -> None:
    """2 for every slave with outputs, 1 for every one with inputs; the coupler has none."""
    assert expected_counter(BENCH) == 3 + 5 + 1 + 2


def test_commands_to_bytes() -> None:
    out = OutputImage(BENCH)
    rows = dict(out.encode([command()], 0x81, 0x1FE))
    drive = rows[1]
    assert drive[0:2] == b"\x0f\0" and drive[2] == 9
    assert out.echo == (1, 3) and drive[3] == 0xFE
    assert [int.from_bytes(drive[i : i + 4], "little") for i in (4, 8, 12)] == [5, 1000, 77]
    assert rows[8] == b"\x81"


def test_targets_are_limited_to_their_type() -> None:
    out = OutputImage(BENCH)
    wild = AxisCommand(0, 1, 0x0F, 9, 2**40, -(2**40), 2**40, 0)
    drive = dict(out.encode([wild], 0, 0))[1]
    values = [int.from_bytes(drive[i : i + 4], "little", signed=True) for i in (4, 8, 12)]
    assert values == [2**31 - 1, -(2**31), 2**31 - 1]


def test_bytes_to_inputs() -> None:
    blank = [bytes((s.input_bits + 7) // 8) for s in BENCH.slaves]
    data = list(blank)
    data[2] = (8388607).to_bytes(4, "little") + bytes(12)
    data[4] = (2**32 - 3).to_bytes(4, "little") + (7).to_bytes(4, "little")
    data[7] = b"\x05"
    data[1] = (
        b"\x37\x02\x09\x00" + (-5).to_bytes(4, "little", signed=True) + bytes(8) + b"\x10\x23"
    )
    found = InputImage(BENCH).decode(data, 12, 34, int(Health.DEGRADED))
    assert found.cycle == 12 and found.stamp_ns == 34 and found.health == 1
    assert found.bridge_volts == (10.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    assert (found.plank_counts, found.wheel_counts) == (-3, 7)
    assert found.digital == Digital.TRIGGER | Digital.LIMIT_FRONT
    assert found.axes[0] == AxisInputs(0x0237, 9, -5, 0, 0, 0x2310)


def test_a_bus_without_an_emergency_contact_has_it_closed() -> None:
    bus = BusFile("x", tuple(s for s in BENCH.slaves if s.name != "digital_in"))
    blank = [bytes((s.input_bits + 7) // 8) for s in bus.slaves]
    assert InputImage(bus).decode(blank, 0, 0, 0).digital == Digital.EMERGENCY_STOP_OK


def test_small_slaves_share_a_byte() -> None:
    places = place_bits([4, 0, 4, 16, 2])
    assert [(p.shift, p.bits) for p in places] == [(0, 4), (0, 0), (4, 4), (0, 0), (0, 2)]
    assert (
        places[2].extract_bits(b"\xa5") == b"\x0a" and places[0].extract_bits(b"\xa5") == b"\x05"
    )
    shared: dict[int, int] = {}
    assert places[0].insert_bits(b"\x05", shared) == b"\x05"
    assert places[2].insert_bits(b"\x0a", shared) == b"\xa5"
    with pytest.raises(BusFileError, match="cross a byte"):
        place_bits([4, 6])


@pytest.mark.parametrize(("bits", "raw", "seen"), [
    (16, [65534, 65535, 0, 3], [65534, 65535, 65536, 65539]),
    (16, [2, 0, 65533], [2, 0, -3]),
    (32, [2**32 - 1, 0, 1], [-1, 0, 1]),
    (24, [2**24 - 1, 0], [2**24 - 1, 2**24]),
])  # fmt: skip
def test_narrow_counters_are_continued(bits: int, raw: list[int], seen: list[int]) -> None:
    counter = CounterExtension(bits)
    assert [counter.extend(value) for value in raw] == seen


def test_messages_come_through_unchanged() -> None:
    inputs = image()._replace(cycle=2**40, stamp_ns=2**60, plank_counts=-(2**31), lvdt_volts=-0.1)
    assert link.unpack_inputs(link.pack_inputs(inputs)) == inputs
    asked = command()._replace(target_position=-(2**31), mode=-1, cycle=2**40)
    assert link.unpack_command(link.pack_command(asked)) == asked


# --- health -------------------------------------------------------------------------------

GOOD, LOST = CycleObservation(True, 11, True), CycleObservation(False, 0, True)
FALLEN = SlaveState("bridges_a", 0x14, 0x1B, "Sync manager watchdog")


def test_losses_are_tolerated_twice() -> None:
    monitor = HealthMonitor(11)
    verdicts = [
        monitor.observe(s) for s in (GOOD, LOST, GOOD, LOST, LOST, GOOD, LOST, LOST, LOST, GOOD)
    ]
    names = [Health(v).name[0] for v in verdicts]
    assert "".join(names) == "ODODDODDLO"
    assert (monitor.sent, monitor.received, monitor.lost) == (10, 4, 6)
    assert sum(monitor.history.values()) == monitor.sent


def test_wrong_counter_and_echo() -> None:
    monitor = HealthMonitor(11)
    assert monitor.observe(CycleObservation(True, 10, True)) == Health.DEGRADED
    assert monitor.observe(CycleObservation(True, 11, False)) == Health.STALE
    for _ in range(3):
        verdict = monitor.observe(CycleObservation(True, 10, True))
    assert verdict == Health.LOST and monitor.reason == "working counter 10 of 11"


def test_a_full_counter_does_not_prove_op() -> None:
    monitor = HealthMonitor(11)
    monitor.register_states((SlaveState("drive", 8, 0, ""), FALLEN))
    assert monitor.observe(GOOD) == Health.SLAVE_FAULT
    assert monitor.reason == "bridges_a: SAFEOP with error 0x001B (Sync manager watchdog)"
    monitor.register_states((SlaveState("drive", 8, 0, ""),))
    assert monitor.observe(GOOD) == Health.OK and monitor.reason == ""


# --- recovery -------------------------------------------------------------------------------


def climb(
    recovery: RecoveryPolicy, health: Health, states: tuple[int, ...], seconds: float, silent=False
) -> list[RecoveryStep]:
    """Steps taken while the bus stays bad."""
    steps = [recovery.step(n * 0.01, health, states, silent) for n in range(round(seconds * 100))]
    return [taken for taken in steps if taken]


def test_axes_get_time_to_stop_first() -> None:
    assert climb(RecoveryPolicy(), Health.SLAVE_FAULT, (0x14,), SETTLE_S) == []


def test_recovery_for_a_slave_in_safeop() -> None:
    taken = climb(
        RecoveryPolicy(), Health.SLAVE_FAULT, (0x14,), SETTLE_S + 3 * EFFECT_TIMEOUT_S + 2.5
    )
    assert taken == [
        RecoveryStep.ACKNOWLEDGE,
        RecoveryStep.RECONFIGURE,
        RecoveryStep.RESCAN,
        RecoveryStep.RESCAN,
        RecoveryStep.RESCAN,
    ]


def test_recovery_for_a_slave_that_lost_its_state() -> None:
    assert climb(RecoveryPolicy(), Health.LOST, (0x02, 0x14), 0.5) == [RecoveryStep.RECONFIGURE]


def test_recovery_on_a_silent_wire() -> None:
    assert climb(RecoveryPolicy(), Health.LOST, (), 5.0, silent=True) == [RecoveryStep.REOPEN]
    assert climb(RecoveryPolicy(), Health.LOST, (0,), 0.4, silent=True)[:2] == [
        RecoveryStep.REOPEN,
        RecoveryStep.RECONFIGURE,
    ]


def test_recovery_for_old_answers() -> None:
    taken = climb(RecoveryPolicy(), Health.STALE, (), 0.1)
    assert set(taken) == {RecoveryStep.REOPEN} and 2 <= len(taken) <= 5


def test_recovery_steps_down_at_once() -> None:
    recovery = RecoveryPolicy()
    climb(recovery, Health.SLAVE_FAULT, (0x14,), 1.0)
    assert recovery.step(1.0, Health.OK, ()) == RecoveryStep.NONE
    assert recovery.step(1.01, Health.SLAVE_FAULT, (0x14,)) == RecoveryStep.NONE
    assert recovery.step(1.02 + SETTLE_S, Health.SLAVE_FAULT, (0x14,)) == RecoveryStep.ACKNOWLEDGE


# --- inbox, clock, histogram --------------------------------------------------------------


def words(inbox: CommandInbox, *sent: int) -> int:
    return inbox.commands_in_force([command(w, n) for n, w in enumerate(sent)])[0].control_word


def test_newest_command_counts() -> None:
    inbox = CommandInbox()
    assert words(inbox, 0, 6, 7) == 7
    assert words(inbox) == 7


def test_a_reset_in_a_burst_is_not_lost() -> None:
    inbox = CommandInbox()
    assert words(inbox, 0, 0x80, 0, 6) == 0x80
    assert words(inbox) == 6
    assert words(inbox, 7) == 7


def test_a_reset_bit_that_stays_delays_nothing() -> None:
    inbox = CommandInbox()
    assert words(inbox, 0x80) == 0x80
    assert words(inbox, 0x80, 0x80, 6) == 6


def test_clock_counts_and_catches_up() -> None:
    clock = CycleClock(PERIOD, 1000)
    assert clock.due() == 1000 + PERIOD and clock.advance(clock.due()) == 1
    late = clock.due() + CATCH_UP * PERIOD
    assert [clock.advance(late) for _ in range(3)] == [2, 3, 4] and clock.missed == 0


@pytest.mark.parametrize(("slip", "number"), [(False, 22), (True, 2)])
def test_clock_after_a_long_stall(slip: bool, number: int) -> None:
    clock = CycleClock(PERIOD, 0, slip)
    clock.advance(clock.due())
    now = clock.due() + 20 * PERIOD
    assert clock.advance(now) == number and clock.missed == 20
    assert 0 < clock.due() - now <= PERIOD


def test_time_waited_for_the_nodes_is_not_made_up_for() -> None:
    clock = CycleClock(4_000_000, 0, slip=True)
    assert clock.advance(4_000_000) == 1
    clock.extend(100_000_000)
    assert clock.advance(108_000_000) == 2
    assert clock.due() == 112_000_000 and clock.missed == 0


def test_only_the_reported_emergencies_are_kept() -> None:
    told: list[dict[str, Any]] = []
    soem: Any = SimpleNamespace(expected=0)
    parent: Any = SimpleNamespace(send_message=told.append, unread=0)
    loop = BusLoop(BENCH, soem, parent, "", Timing())
    for code in range(100):
        soem.emergency("wheel_drive", code, 1)
    reported = [e["code"] for e in loop.report()["emergencies"]]
    assert reported == list(range(80, 100)) and len(loop.emergencies) == 20
    assert [e["code"] for e in told] == list(range(100))


def test_histogram() -> None:
    histogram = Histogram()
    for value in range(1, 1001):
        histogram.add(value * 1000)
    report = histogram.report()
    assert report["count"] == 1000 == sum(report["bins_us"].values())
    assert report["worst_us"] == 1000.0
    assert report["p50_us"] == pytest.approx(500, rel=0.25)
    assert report["p99_us"] == pytest.approx(990, rel=0.25)
    histogram.add(10**12)
    assert histogram.report()["worst_us"] == 1e9
    assert Histogram().report()["p99_us"] == 0.0
