# SPDX-License-Identifier: Apache-2.0
"""The loop of the bus process on a wire, a parent and a clock made up, cycle by cycle."""

from __future__ import annotations

from collections import deque
from types import SimpleNamespace
from typing import Any

import pytest
from ethercat_rig import BUS_FILES, RUN, command

from flatplank_hw.bus.image import AxisCommand, BusInputs, Health
from flatplank_hw.ethercat.master import loop as loops
from flatplank_hw.ethercat.master.guard import Cause
from flatplank_hw.ethercat.master.health import SlaveState
from flatplank_hw.ethercat.master.interface import BusError
from flatplank_hw.ethercat.master.loop import BusLoop, Timing
from flatplank_hw.ethercat.master.soem import Exchange
from flatplank_hw.ethercat.reader import read_bus_file

BENCH = read_bus_file(BUS_FILES / "bench.yaml")
PERIOD = 4_000_000
GOOD, LOST, SHORT = Exchange(True, 11, 50_000), Exchange(False, 0, 0), Exchange(True, 10, 50_000)
RESTING = {1: bytes(16), 8: b"\0"}
"""outputs of drive and lamps that ask for nothing"""
FALLEN = SlaveState("bridges_a", 0x14, 0x1B, "watchdog")


class Wire:
    """Slaves that answer what they are told to; what is asked of them is kept."""

    def __init__(self) -> None:
        self.expected, self.interface, self.mapped = 11, "eth7", True
        self.emergency: Any = None
        self.asked: list[Any] = []
        self.sent: list[dict[int, bytes]] = []
        self.timeouts: list[float] = []
        self.result, self.old_echo, self.velocity = GOOD, False, 0
        self.found: tuple[SlaveState, ...] = ()
        self.repaired, self.trouble, self.data = True, "", True

    def exchange(self, outputs, timeout_s: float) -> Exchange:
        self.sent.append(dict(outputs))
        self.timeouts.append(timeout_s)
        return self.result

    def output_byte(self, slave: int, byte: int) -> int:
        return self.sent[-1][slave][byte] - self.old_echo

    def inputs(self) -> list[bytes]:
        """The speed of the wheel, and a count of the cycles at the plank's encoder."""
        blank = [bytearray((s.input_bits + 7) // 8) for s in BENCH.slaves]
        blank[1][0:2] = b"\x37\x02"
        blank[1][8:12] = self.velocity.to_bytes(4, "little", signed=True)
        blank[4][0:4] = len(self.sent).to_bytes(4, "little")
        blank[7][0] = 2
        return [bytes(b) for b in blank] if self.data else []

    def states(self) -> tuple[SlaveState, ...]:
        self.asked.append("states")
        return self.found

    def poll_mailbox(self, number: int) -> None:
        self.asked.append(number)

    def reconfigure(self) -> bool:
        self.asked.append("reconfigure")
        return self.repaired

    def to_op(self, outputs) -> None:
        self.asked.append(("to_op", dict(outputs)))

    def __getattr__(self, name: str):
        def act() -> None:
            self.asked.append(name)
            if self.trouble:
                raise BusError(self.trouble)

        if name in ("scan", "configure", "reopen", "acknowledge"):
            return act
        raise AttributeError(name)


class Parent:
    """The other end of the sockets."""

    def __init__(self) -> None:
        self.parent_gone, self.unread = False, 3
        self.images: list[BusInputs] = []
        self.said: list[dict[str, Any]] = []
        self.waiting: deque[dict[str, Any]] = deque()

    def requests(self) -> list[dict[str, Any]]:
        asked = list(self.waiting)
        self.waiting.clear()
        return asked

    def await_commands(self, seconds: float) -> list[AxisCommand]:
        raise AssertionError("the wait is made up")

    def publish(self, inputs: BusInputs) -> None:
        self.images.append(inputs)

    def send_message(self, message: dict[str, Any]) -> None:
        self.said.append(message)


class Bench:
    """A loop whose cycles begin when they are due."""

    def __init__(self, monkeypatch, timing: Timing | None = None, bus=BENCH) -> None:
        self.now, self.late = 1000, 0
        self.wire, self.parent = Wire(), Parent()
        self.commands: list[AxisCommand] = []
        self.waits: list[tuple[int, int, int, bool]] = []
        clock = SimpleNamespace(
            perf_counter_ns=lambda: self.now, monotonic=lambda: self.now * 1e-9
        )
        monkeypatch.setattr(loops, "time", clock)
        soem: Any = self.wire
        self.loop = BusLoop(bus, soem, self.parent, "FIFO 80", timing or Timing())
        self.loop.waiting = SimpleNamespace(wait_for_cycle=self.wait, waited_ns=0, given_up=4)
        served = self.loop.sdos.serve
        self.loop.sdos.serve = lambda wire: self.wire.asked.append("sdo") or served(wire)

    def wait(self, cycle: int, begun: int, due: int, take, go_on) -> list[AxisCommand]:
        self.waits.append((cycle, begun, due, go_on()))
        self.loop.waiting.waited_ns += self.late
        self.now = due + self.late
        commands, self.commands = self.commands, []
        return commands

    def cycles(self, count: int, result: Exchange | None = None) -> list[BusInputs]:
        """Images of some cycles; the first two lift the stop with which a bus begins."""
        self.wire.result = result or self.wire.result
        for _ in range(count):
            cycle = self.loop.clock.cycle + 1
            word = {1: 0x00, 2: 0x80}.get(cycle, RUN)
            self.commands = self.commands or [command(word, cycle)]
            self.loop.run_cycle()
        return self.parent.images[-count:]

    def words(self) -> list[int]:
        """Control words that went to the wheel."""
        return [int.from_bytes(data[1][:2], "little") for data in self.wire.sent]


@pytest.fixture
def bench(monkeypatch) -> Bench:
    return Bench(monkeypatch)


def test_a_good_cycle(bench):
    images = bench.cycles(3)
    assert [(i.cycle, i.stamp_ns, i.health) for i in images] == [
        (n, n * PERIOD, Health.OK) for n in (1, 2, 3)
    ]
    assert [i.plank_counts for i in images] == [1, 2, 3] and images[0].digital == 2
    assert bench.waits == [(n, 1000 + (n - 1) * PERIOD if n > 1 else 0, 1000 + n * PERIOD, True)
                           for n in (1, 2, 3)]  # fmt: skip
    assert [data[1][3] for data in bench.wire.sent] == [1, 2, 3]  # the echo
    report = bench.loop.report()
    assert (report["cycle_time"]["count"], report["round_trip"]["count"]) == (2, 3)
    assert report["cycle_time"]["worst_us"] == 4000.0 and report["round_trip"]["worst_us"] == 50.0


@pytest.mark.parametrize(
    ("rate", "given", "timeout"), [(250, 0.0, 0.002), (1000, 0.0, 0.0006), (250, 0.005, 0.005)]
)
def test_how_long_an_answer_is_waited_for(monkeypatch, rate, given, timeout):
    bus = read_bus_file(BUS_FILES / "bench.yaml")
    bus = type(bus)(bus.name, bus.slaves, rate)
    bench = Bench(monkeypatch, Timing(reply_timeout_s=given), bus)
    bench.cycles(1)
    assert bench.wire.timeouts == [pytest.approx(timeout)]


def test_the_digital_outputs_of_all_axes_are_joined(bench):
    bench.cycles(2)
    for cycle, bits in ((3, (1, 2, 8)), (4, (0, 0, 0)), (5, (1, 0, 0))):
        bench.commands = [
            command(RUN, cycle, axis)._replace(digital_outputs=bit)
            for axis, bit in zip((0, 1, 3), bits, strict=True)
        ]
        bench.cycles(1)
    assert [data[8] for data in bench.wire.sent[2:]] == [b"\x0b", b"\x00", b"\x01"]


def test_the_time_that_nodes_are_waited_for_moves_the_schedule(bench):
    bench.late = PERIOD // 4
    bench.cycles(3)
    dues = [due for _, _, due, _ in bench.waits]
    assert dues == [
        1000 + PERIOD,
        1000 + 2 * PERIOD + PERIOD // 4,
        1000 + 3 * PERIOD + PERIOD // 2,
    ]


def test_lost_frames_keep_the_last_inputs_and_count_on(bench):
    bench.cycles(3)
    bench.wire.velocity = 99
    images = bench.cycles(4, LOST)
    healths = [Health.DEGRADED, Health.DEGRADED, Health.LOST, Health.LOST]
    assert [i.health for i in images] == healths
    assert [i.cycle for i in images] == [4, 5, 6, 7]
    assert [i.stamp_ns for i in images] == [n * PERIOD for n in (4, 5, 6, 7)]
    assert all((i.plank_counts, i.axes[0].velocity) == (3, 0) for i in images)
    (again,) = bench.cycles(1, GOOD)
    assert (again.health, again.plank_counts, again.axes[0].velocity) == (Health.OK, 8, 99)
    assert bench.loop.report()["round_trip"]["count"] == 4


def test_a_counter_too_small_is_taken_while_it_is_tolerated(bench):
    bench.cycles(1)
    images = bench.cycles(4, SHORT)
    assert [i.plank_counts for i in images] == [2, 3, 3, 3]


def test_answers_of_an_older_cycle_are_not_taken(bench):
    bench.cycles(1)
    bench.wire.old_echo = True
    (stale,) = bench.cycles(1)
    assert (stale.health, stale.plank_counts) == (Health.STALE, 1)
    assert bench.loop.report()["stale"] == 1


def test_a_bus_without_an_echo_cannot_be_stale(bench):
    bench.loop.outputs.echo = None
    bench.wire.old_echo = True
    assert [i.health for i in bench.cycles(2)] == [Health.OK, Health.OK]
    assert bench.loop.report()["echo"] is False


@pytest.mark.parametrize("data", [True, False])
def test_the_first_image_of_a_silent_wire(bench, data):
    """It has what the slaves had at the start, or zeros."""
    bench.wire.data, bench.wire.velocity = data, 7
    (image,) = bench.cycles(1, LOST)
    assert image.axes[0].velocity == 7 * data and image.digital == 2 * data
    bench.wire.data, bench.wire.velocity = True, 9
    (image,) = bench.cycles(1, LOST)
    assert image.axes[0].velocity == 7 * data


def test_what_is_done_beside_the_cycles(bench):
    """States every tenth cycle, the mailboxes in turn every second one, requests in the others."""
    bench.cycles(21)
    expected = ["sdo" if n % 2 else "box" for n in range(1, 22)]
    expected[9] = expected[19] = "states"
    boxes = iter((2, 3, 4, 5, 6, 1, 2, 3, 4, 5))
    assert bench.wire.asked == [next(boxes) if e == "box" else e for e in expected]


def test_states_are_read_often_while_they_are_in_doubt(bench):
    bench.cycles(3)
    bench.wire.asked.clear()
    bench.cycles(4, SHORT)
    assert bench.wire.asked == ["states", "sdo", "states", "sdo"]


def test_a_silent_wire_is_asked_seldom_and_its_interface_often(bench, monkeypatch):
    looked: list[int] = []
    monkeypatch.setattr(
        loops, "link_trouble", lambda name: looked.append(bench.loop.monitor.in_a_row) or name
    )
    bench.wire.asked.clear()
    bench.cycles(60, LOST)
    assert looked == [5, 10, 15, 20, 25, 30, 35, 40, 45, 50, 55, 60]
    assert bench.loop.monitor.link == "eth7"
    assert bench.wire.asked.count("states") == 1  # cycle 50; at 25 it was not silent yet
    bench.cycles(40)
    assert bench.wire.asked.count("states") == 3


def test_after_a_stall_the_states_are_read(bench):
    bench.cycles(2)
    bench.wire.asked.clear()
    bench.late = 20 * PERIOD
    bench.loop.clock.extend(-20 * PERIOD)
    bench.loop.waiting.wait_for_cycle = lambda *_: setattr(bench, "now", bench.now + 30 * PERIOD)
    bench.loop.inbox.commands_in_force = lambda commands: {}
    bench.loop.run_cycle()
    assert bench.wire.asked == ["states"]
    assert bench.loop.report()["missed"] == bench.loop.clock.missed > 20


def recovered(bench: Bench) -> list[str]:
    """Steps that the parent was told of."""
    return [message["step"] for message in bench.parent.said if message.get("event") == "recovery"]


def test_a_fallen_slave_is_acknowledged_then_configured_then_searched_for(bench):
    bench.cycles(9)
    bench.wire.found = (FALLEN,)
    bench.cycles(1)
    (fallen,) = bench.cycles(1)
    assert fallen.health == Health.SLAVE_FAULT
    bench.wire.asked.clear()
    bench.cycles(240)
    assert recovered(bench) == ["ACKNOWLEDGE", "RECONFIGURE", "RESCAN"]
    done = [a for a in bench.wire.asked if a not in ("states", "sdo") and not isinstance(a, int)]
    assert done == [
        "acknowledge", "reopen", "reconfigure", "acknowledge", "reopen", "scan", "configure",
        ("to_op", RESTING),
    ]  # fmt: skip
    assert bench.parent.said[0]["reason"] == "bridges_a: SAFEOP with error 0x001B (watchdog)"
    report = bench.loop.report()
    assert report["recovery"] == {"ACKNOWLEDGE": 1, "RECONFIGURE": 1, "RESCAN": 1}
    assert report["not_in_op"] == {"bridges_a": 0x14} and report["health"] == "SLAVE_FAULT"
    bench.wire.found = ()
    bench.cycles(20)
    assert bench.loop.health == Health.OK and bench.loop.report()["reason"] == ""


@pytest.mark.parametrize(("mapped", "repaired"), [(False, True), (True, False)])
def test_a_slave_that_cannot_be_configured_is_not_acknowledged(bench, mapped, repaired):
    bench.wire.mapped, bench.wire.repaired = mapped, repaired
    bench.loop._reconfigure()
    assert bench.wire.asked == ["reopen", "reconfigure"][: 1 + mapped]


def test_a_step_that_fails_is_the_reason_until_one_works(bench):
    bench.wire.found = (FALLEN,)
    bench.wire.trouble = "no slaves"
    bench.cycles(100)
    assert bench.loop.report()["reason"] == "no slaves"
    bench.wire.trouble = ""
    bench.cycles(60)
    assert bench.loop.report()["reason"].startswith("bridges_a: SAFEOP")


def test_the_recovery_starts_over_when_the_bus_is_well(bench):
    bench.wire.found = (FALLEN,)
    bench.cycles(100)
    bench.wire.found = ()
    bench.cycles(20)
    bench.wire.found = (FALLEN,)
    bench.cycles(100)
    assert recovered(bench) == ["ACKNOWLEDGE", "ACKNOWLEDGE"]


def test_mailboxes_and_requests_wait_while_the_bus_is_bad(bench):
    """No mailbox is asked of a bad bus; requests are served while it is known to be bad."""
    bench.cycles(9)
    bench.wire.found = (FALLEN,)
    bench.cycles(2)
    bench.wire.asked.clear()
    bench.cycles(8)
    assert bench.wire.asked == ["sdo"] * 8
    bench.wire.found = ()
    bench.cycles(3)
    bench.wire.asked.clear()
    bench.cycles(2, LOST)
    assert bench.wire.asked == []


def test_requests_of_the_parent(bench):
    bench.cycles(1)
    read = {"id": 1, "do": "sdo_read", "slave": "nobody", "index": 0, "subindex": 0}
    bench.parent.waiting += [read, {"id": 2, "do": "dance"}, {"id": 3, "do": "diagnostics"}]
    bench.parent.waiting.append({**read, "id": 4, "do": "sdo_write", "data": ""})
    bench.cycles(1)
    first, second, third, fourth = bench.parent.said
    assert (first["id"], first["ok"], fourth["id"], fourth["ok"]) == (1, False, 4, False)
    assert "no slave 'nobody'" in first["reason"] and "no slave 'nobody'" in fourth["reason"]
    assert second == {"id": 2, "ok": False, "reason": "unknown 'dance'"}
    assert (third["id"], third["ok"]) == (3, True)
    assert third["diagnostics"]["cycle"] == 2
    assert bench.loop.running


def test_the_report(bench):
    bench.cycles(3)
    bench.cycles(1, SHORT)
    bench.cycles(3, LOST)
    bench.wire.emergency("wheel_drive", 0x4210, 8)
    bench.loop._emergency("wheel_drive", 0x4210, 8)
    report = bench.loop.report()
    expected = {
        "health": "LOST", "cycle": 7, "rate_hz": 250, "scheduling": "FIFO 80", "sent": 7,
        "received": 4, "lost": 3, "wrong_counter": 1, "missed": 0, "waited_ms": 0, "given_up": 4,
        "stale": 0, "unread": 3, "echo": True, "recovery": {}, "not_in_op": {},
        "history": {"OK": 3, "DEGRADED": 2, "LOST": 2}, "stops": {"BUS": 2},
        "held": {"wheel": "BUS"}, "reason": "no answer for 4 cycles",
    }  # fmt: skip
    assert {key: report[key] for key in expected} == expected
    told = {"cycle": 7, "slave": "wheel_drive", "code": 0x4210, "register": 8}
    assert report["emergencies"] == [told, told]
    bench.loop.waiting.waited_ns = 2_600_000
    assert bench.loop.report()["waited_ms"] == 3


def test_a_held_axis_is_shown_in_fault_and_what_was_read_is_kept(bench):
    bench.cycles(2)
    images = bench.cycles(4, LOST)
    assert images[3].axes[0].status_word & 0x4F == 0x08
    assert images[3].axes[0].error_code == Cause.BUS
    assert bench.loop.inputs.axes[0].status_word == 0x0237


@pytest.mark.parametrize("end", ["stop", "gone"])
def test_the_end_stops_the_axes_first(bench, end):
    """Quick stop while an axis turns, at most 0.4 s; then the voltage goes, for five cycles."""
    bench.cycles(3)
    bench.wire.velocity = -2001
    publish = bench.parent.publish

    def published(inputs: BusInputs) -> None:
        publish(inputs)
        if inputs.cycle == 4:
            if end == "stop":
                bench.parent.waiting.append({"do": "stop", "id": 0})
            else:
                bench.parent.parent_gone = True
        if inputs.cycle == 30:
            bench.wire.velocity = 2000

    bench.parent.publish = published
    bench.loop.run()
    assert bench.words() == [0x02, 0x80, RUN, RUN] + [0x02] * 27 + [0x00] * 5
    assert bench.loop.guard.stops == {"BUS": 1, "STALE_COMMAND": 5}
    assert bench.waits[-1][3] is False


def test_the_end_does_not_wait_for_ever_for_an_axis_that_turns(bench):
    """0.4 s, 0.25 s of which it brakes."""
    bench.cycles(2)
    bench.wire.velocity = 2001
    bench.cycles(1)
    bench.loop.running = False
    bench.loop.run()
    assert bench.words()[3:] == [0x02] * 61 + [0x00] * (39 + 5)


@pytest.mark.parametrize("known", [True, False])
def test_without_a_wire_nothing_is_waited_for(bench, known):
    if known:
        bench.wire.velocity = 2001
        bench.cycles(1)
        bench.wire.mapped = False
    before = len(bench.wire.sent)
    bench.loop.running = False
    bench.loop.run()
    assert len(bench.wire.sent) == before + 5


def test_the_start(bench):
    bench.now = 5000
    bench.loop.start()
    assert bench.wire.asked == ["scan", "configure", ("to_op", RESTING)]
    assert bench.loop.clock.due() == 5000 + PERIOD
