# SPDX-License-Identifier: Apache-2.0
"""The client of the bus process, with a process made up: sockets, images, requests, ends."""

from __future__ import annotations

import json
import os
import socket
import subprocess
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any, ClassVar

import pytest
from ethercat_rig import BENCH, command, image

from flatplank_hw.bus.image import BusInputs, Health
from flatplank_hw.ethercat.master import client as clients
from flatplank_hw.ethercat.master import link
from flatplank_hw.ethercat.master.client import BusClient
from flatplank_hw.ethercat.master.interface import BusError

PERIOD = 4_000_000


class Process:
    """A bus process: it says what it is told to when it starts."""

    says: tuple[dict[str, Any], ...] = ({"event": "ready"},)
    code: int | None = None
    deaf = False
    made: ClassVar[list[Process]] = []

    def __init__(self, words, pass_fds, env, stdin) -> None:
        self.words, self.env = words, env
        self.data, self.control = (socket.socket(fileno=os.dup(fd)) for fd in pass_fds)
        self.control.settimeout(1.0)
        self.pid, self.done, self.polls = 4711, [], 0
        self.code = type(self).code
        for message in self.says:
            self.say(message)
        self.made.append(self)

    def say(self, message: dict[str, Any]) -> None:
        self.control.send(json.dumps(message).encode())

    def hear(self) -> dict[str, Any]:
        return json.loads(self.control.recv(65536))

    def publish(self, *images: BusInputs) -> None:
        for one in images:
            self.data.send(link.pack_inputs(one))

    def poll(self) -> int | None:
        self.polls += 1
        return self.code

    def wait(self, timeout: float | None = None) -> int:
        self.done.append(("wait", timeout))
        if self.deaf and timeout is not None:
            raise subprocess.TimeoutExpired("bus", timeout)
        return 0

    def kill(self) -> None:
        self.done.append("kill")


@pytest.fixture
def process(monkeypatch) -> Iterator[type[Process]]:
    """The class of the processes that are started."""
    kind = type("Made", (Process,), {"made": []})
    monkeypatch.setattr(clients.subprocess, "Popen", kind)
    yield kind
    for made in kind.made:
        made.data.close()
        made.control.close()


def started(process, **options) -> tuple[BusClient, Process]:
    client = BusClient(BENCH, "eth7", **options)
    client.start(0.5)
    return client, process.made[-1]


def numbered(cycle: int) -> BusInputs:
    return image()._replace(cycle=cycle, stamp_ns=cycle * PERIOD)


def test_a_process_that_cannot_start_gives_its_reason(process):
    process.says = ({"event": "hello"}, {"event": "failed", "reason": "no slaves on 'eth7'"})
    client = BusClient(BENCH, "eth7")
    with pytest.raises(BusError, match="no slaves on 'eth7'"):
        client.start(0.5)
    assert client.process is None and not client.alive
    assert process.made[0].done == [("wait", 1.0)]


def test_a_process_that_ends_before_it_is_ready(process):
    """What it has said before its end is read first."""
    process.code = 3
    client, made = started(process)
    made.code = None
    client.stop(0.0)
    process.says = ()
    with pytest.raises(BusError, match="ended with code 3 before it was ready"):
        BusClient(BENCH, "eth7").start(0.5)


# images


@pytest.fixture
def clock(monkeypatch):
    """Time that goes on only when a test says so."""
    made = SimpleNamespace(now=100.0, slept=[])
    made.monotonic = lambda: made.now
    made.sleep = made.slept.append
    monkeypatch.setattr(clients, "time", made)
    return made


def test_images_come_in_order_and_no_number_comes_twice(process, clock):
    client, made = started(process)
    made.publish(numbered(0), numbered(1), numbered(2), numbered(5))
    assert client.poll(0.0) == [numbered(1), numbered(2), numbered(5)]
    made.publish(numbered(5), numbered(6))
    assert client.poll(0.5) == [numbered(6)]
    assert client.poll(0.0) == [] and client.invented == 0
    client.stop(0.0)


def test_a_poll_waits_for_an_image_only_when_it_may(process, clock, monkeypatch):
    client, made = started(process)
    waited: list[float] = []
    monkeypatch.setattr(
        clients, "select", SimpleNamespace(select=lambda *a: waited.append(a[3]) or ([], [], []))
    )
    assert client.poll(0.0) == [] and waited == []
    assert client.poll(0.25) == [] and waited == [0.25]
    made.publish(numbered(1))
    assert client.poll(0.25) == [numbered(1)] and waited == [0.25]
    monkeypatch.undo()
    client.stop(0.0)


@pytest.mark.parametrize(("slip", "cycles"), [(False, (17, 19, 20)), (True, (5, 6, 7))])
def test_without_images_the_client_makes_its_own(process, clock, slip, cycles):
    """Their numbers go on by the wall clock, or without a gap on a bus that slips."""
    client, made = started(process, slip=slip)
    made.publish(numbered(4))
    (last,) = client.poll(0.0)
    found = []
    for gone, expected in ((0.049, 0), (0.003, 1), (0.0, 0), (0.051, 1), (0.0501, 1)):
        clock.now += gone
        images = client.poll(0.0)
        assert len(images) == expected
        found += images
    by_clock = (4 + 13, 17 + 13, 30 + 13)
    numbers = tuple(one.cycle for one in found)
    assert numbers == (cycles if slip else by_clock)
    assert all(one.stamp_ns == one.cycle * PERIOD for one in found)
    assert all(one.health == Health.LOST for one in found) and client.invented == 3
    assert found[0] == last._replace(
        cycle=numbers[0], stamp_ns=numbers[0] * PERIOD, health=Health.LOST
    )
    made.publish(numbered(numbers[-1]), numbered(numbers[-1] + 1))
    assert client.poll(0.0) == [numbered(numbers[-1] + 1)]
    client.stop(0.0)


def test_a_made_image_is_at_least_the_next_one(process, clock):
    client, made = started(process, rate_hz=1)
    made.publish(numbered(4))
    client.poll(0.0)
    clock.now += 0.051
    assert client.poll(0.0)[0].cycle == 5
    client.stop(0.0)


@pytest.mark.parametrize(("code", "silence"), [(None, 0.08), (0, 0.05)])
def test_a_process_that_waits_for_nodes_may_be_silent_for_longer(process, clock, code, silence):
    """By 1.5 times the wait, as long as it runs."""
    client, made = started(process, node_timeout_ms=20.0)
    made.code = code
    clock.now += silence - 1e-3
    assert client.poll(0.0) == []
    clock.now += 2e-3
    assert len(client.poll(0.0)) == 1
    made.code = None
    client.stop(0.0)


def test_a_closed_socket_is_silence(process, clock):
    client, made = started(process)
    made.data.close()
    assert client.poll(0.0) == [] and clock.slept == [PERIOD * 1e-9]
    client.send(command())  # is lost, without an error
    client.stop(0.0)


def test_commands_are_sent(process):
    client, made = started(process)
    client.send(command(0x0F, 7, 2))
    assert link.unpack_command(made.data.recv(100)) == command(0x0F, 7, 2)
    client.stop(0.0)


# requests


@pytest.mark.parametrize(
    ("ask", "answer", "request_", "found"),
    [
        (lambda c: c.sdo_read("drive", 0x6041, 2), {"data": "370a"},
         {"do": "sdo_read", "slave": "drive", "index": 0x6041, "subindex": 2}, b"\x37\x0a"),
        (lambda c: c.sdo_read("drive", 0x6041), {"data": ""},
         {"do": "sdo_read", "slave": "drive", "index": 0x6041, "subindex": 0}, b""),
        (lambda c: c.sdo_write("drive", 0x6085, 1, b"\x01\xff"), {"data": ""},
         {"do": "sdo_write", "slave": "drive", "index": 0x6085, "subindex": 1, "data": "01ff"},
         None),
        (lambda c: c.diagnostics(), {"diagnostics": {"lost": 3}}, {"do": "diagnostics"},
         {"lost": 3}),
    ],
)  # fmt: skip
def test_a_request_and_its_answer(process, ask, answer, request_, found):
    """Events, answers to older requests and other messages may come before it."""
    events: list[dict[str, Any]] = []
    client, made = started(process, on_event=events.append)
    for number in (1, 2):
        made.say({"event": "emergency", "code": number})
        made.say({"id": number - 1, "ok": False, "reason": "too late"})
        made.say({"id": number, "ok": True, **answer})
        assert ask(client) == found
        assert made.hear() == {"id": number, **request_}
    assert [event["code"] for event in events] == [1, 2]
    client.stop(0.0)


def test_a_request_that_is_refused_gives_the_reason(process):
    client, made = started(process)
    made.say({"id": 1, "ok": False, "reason": "no such object"})
    with pytest.raises(LookupError, match="no such object"):
        client.sdo_read("drive", 1)
    client.stop(0.0)


@pytest.mark.parametrize(("code", "reason"), [(None, "no answer in time"), (0, "process is gone")])
def test_a_request_without_an_answer(process, code, reason):
    client, made = started(process)
    made.code = code
    with pytest.raises(LookupError, match=reason):
        client.diagnostics(0.02)
    client.stop(0.0)


def test_requests_to_a_closed_socket_get_no_answer(process):
    client, made = started(process)
    made.control.close()
    with pytest.raises(LookupError, match="no answer in time"):
        client.diagnostics(0.02)
    client.stop(0.0)
