# SPDX-License-Identifier: Apache-2.0
"""What is checked before the first cycle; requests to objects; what a slave is told at start."""

from __future__ import annotations

import os
import socket
import sys
from types import SimpleNamespace
from typing import Any

import pytest
from ethercat_rig import BUS_FILES

from flatplank_hw.ethercat.busfile import BusFile, Slave
from flatplank_hw.ethercat.master import interface as checks
from flatplank_hw.ethercat.master.interface import BusError, InterfaceLock, check_identities
from flatplank_hw.ethercat.master.sdo import QUEUE, SdoQueue
from flatplank_hw.ethercat.reader import read_bus_file

BENCH = read_bus_file(BUS_FILES / "bench.yaml")


@pytest.mark.parametrize(
    ("name", "known", "reason"),
    [
        ("eth7", ["lo", "eth7"], ""), ("a" * 15, ["a" * 15], ""),
        ("", ["lo"], "no interface given; 'ip link'"),
        ("a" * 16, ["a" * 16], f"'{'a' * 16}': names have at most 15 characters"),
        ("ä" * 8, ["ä" * 8], "names have at most 15 characters"),
        ("eth8", ["lo", "eth7"], "'eth8' is not there; found: lo, eth7"),
        ("eth8", [], "'eth8' is not there; found: none"),
    ],
)  # fmt: skip
def test_the_name_of_an_interface(monkeypatch, name, known, reason):
    monkeypatch.setattr(checks.socket, "if_nameindex", lambda: list(enumerate(known, 1)))
    if not reason:
        return checks.check_interface(name)
    with pytest.raises(BusError) as raised:
        checks.check_interface(name)
    assert reason in str(raised.value)
    return None


@pytest.mark.parametrize(
    ("flags", "trouble"),
    [(0x41, ""), (0x1041, ""), (0x01, "no link"), (0x40, "the interface is down"),
     (0x00, "the interface is down: sudo ip link set eth7 up")],
)  # fmt: skip
def test_the_link_of_an_interface(monkeypatch, flags, trouble):
    asked: list[bytes] = []

    def ioctl(control, request: int, raw: bytes) -> bytes:
        assert request == 0x8913
        asked.append(raw)
        return raw[:16] + flags.to_bytes(2, sys.byteorder) + raw[18:]

    monkeypatch.setattr(checks.fcntl, "ioctl", ioctl)
    found = checks.link_trouble("eth7")
    assert found.startswith(trouble) and bool(found) == bool(trouble)
    assert asked == [b"eth7" + bytes(36)]


def test_a_raw_socket_needs_a_permission(monkeypatch):
    opened: list[Any] = []

    def allowed(*given: int) -> Any:
        opened.append(given)
        return SimpleNamespace(close=lambda: opened.append("closed"))

    monkeypatch.setattr(checks.socket, "socket", allowed)
    checks.check_permission()
    assert opened == [(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(0x88A4)), "closed"]

    def refused(*_: int) -> None:
        raise PermissionError

    monkeypatch.setattr(checks.socket, "socket", refused)
    with pytest.raises(BusError, match=f"setcap .* {os.path.realpath(sys.executable)}"):
        checks.check_permission()


def test_an_interface_has_one_master(tmp_path):
    first, second, other = (InterfaceLock(n, tmp_path) for n in ("eth7", "eth7", "eth8"))
    first.acquire()
    other.acquire()
    assert first.path.read_text() == f"{os.getpid()}\n"
    with pytest.raises(BusError) as raised:
        second.acquire()
    assert f"'eth7' is in use by process {os.getpid()}; stop it first" in str(raised.value)
    first.path.write_text("")
    with pytest.raises(BusError, match="in use by process unknown"):
        second.acquire()
    first.release()
    first.release()  # once is enough
    first.path.write_text("a number that is longer than the next one\n")
    second.acquire()
    assert second.path.read_text() == f"{os.getpid()}\n"
    second.release()
    other.release()
    assert first.path.exists()
    namespace = os.stat("/proc/self/ns/net").st_ino
    assert first.path == tmp_path / f"flatplank-ethercat-{namespace}-eth7.lock"
    assert InterfaceLock("eth7").path.name == first.path.name
    assert InterfaceLock("eth7").path.parent != tmp_path


def test_a_lock_file_that_cannot_be_opened_is_named(tmp_path):
    lock = InterfaceLock("eth7", tmp_path / "nowhere")
    with pytest.raises(BusError, match=r"lock file .*eth7.lock: No such file or directory"):
        lock.acquire()


A = Slave("a", "coupler", 2, 10, 100)
B = Slave("b", "drive", 3, 11, 101, check_revision=True)
C = Slave("c", "encoder", 4, 12, 102)
SEEN_A, SEEN_B, SEEN_C = ("A", 2, 10, 999), ("B", 3, 11, 101), ("C", 4, 12, 0)


@pytest.mark.parametrize(
    ("found", "reason"),
    [
        ((SEEN_A, SEEN_B, SEEN_C), ""),
        ((), "no slaves on 'eth7'"),
        ((SEEN_A, SEEN_B), "2 of 3 slaves on 'eth7', missing from 'c' on (c);"),
        ((SEEN_A,), "1 of 3 slaves on 'eth7', missing from 'b' on (b, c);"),
        ((SEEN_A, SEEN_B, SEEN_C, ("D", 1, 1, 1), ("E", 1, 1, 1)),
         "5 slaves on 'eth7', the bus file has 3; unknown: 'D', 'E';"),
        ((("X", 9, 10, 100), SEEN_B, SEEN_C), "slave 1 on 'eth7' is 'X' (vendor 0x00000009,"),
        ((SEEN_A, ("B", 3, 99, 101), SEEN_C),
         "slave 2 on 'eth7' is 'B' (vendor 0x00000003, product 0x00000063, revision 0x00000065),"
         " the bus file has 'b' (0x00000003, 0x0000000B, 0x00000065)"),
        ((SEEN_A, ("B", 3, 11, 100), SEEN_C), "slave 2 on 'eth7' is 'B'"),
        ((SEEN_A, ("C", 4, 12, 0)), "slave 2 on 'eth7' is 'C'"),
    ],
)  # fmt: skip
def test_the_slaves_must_be_those_of_the_bus_file(found, reason):
    bus = BusFile("x", (A, B, C))
    if not reason:
        return check_identities(bus, found, "eth7")
    with pytest.raises(BusError) as raised:
        check_identities(bus, found, "eth7")
    assert str(raised.value).startswith(reason)
    return None


# objects


class Wire:
    """Objects of slaves by (number of the slave, index, subindex)."""

    def __init__(self) -> None:
        self.objects = {(1, 0x6041, 0): b"\x37\x02"}

    def sdo_read(self, *place: int) -> bytes:
        if place not in self.objects:
            raise LookupError(f"no object {place}")
        return self.objects[place]

    def sdo_write(self, slave: int, index: int, subindex: int, data: bytes) -> None:
        if not data:
            raise LookupError("nothing to write")
        self.objects[slave, index, subindex] = data


def asked(number: int, do: str = "sdo_read", slave: str = "wheel_drive", **more: Any) -> dict:
    return {"id": number, "do": do, "slave": slave, "index": 0x6041, "subindex": 0, **more}


def test_requests_are_served_one_by_one_in_order():
    answers: list[dict[str, Any]] = []
    queue, wire = SdoQueue(BENCH, answers.append), Wire()
    for request in (asked(1), asked(2, index=7), asked(3, "sdo_write", subindex=4, data="01ff"),
                    asked(4, "sdo_write", data=""), asked(5, slave="digital_out")):  # fmt: skip
        queue.put(request)
    assert answers == []
    assert [queue.serve(wire) for _ in range(7)] == [True] * 5 + [False] * 2
    assert answers == [
        {"id": 1, "ok": True, "data": "3702"},
        {"id": 2, "ok": False, "reason": "no object (1, 7, 0)"},
        {"id": 3, "ok": True, "data": ""},
        {"id": 4, "ok": False, "reason": "nothing to write"},
        {"id": 5, "ok": False, "reason": f"no object ({len(BENCH.slaves) - 1}, 24641, 0)"},
    ]
    assert wire.objects[1, 0x6041, 4] == b"\x01\xff"


@pytest.mark.parametrize(
    ("request_", "reason"),
    [(asked(1, slave="wheel_driv"), "no slave 'wheel_driv'; the nearest is 'wheel_drive'"),
     ({"id": 1, "do": "sdo_read"}, "no slave 'None'; known are bridges_a, bridges_b, coupler,")],
)  # fmt: skip
def test_a_request_to_an_unknown_slave_is_refused_at_once(request_, reason):
    answers: list[dict[str, Any]] = []
    queue = SdoQueue(BENCH, answers.append)
    queue.put(request_)
    (answer,) = answers
    assert (answer["id"], answer["ok"]) == (1, False) and answer["reason"].startswith(reason)
    assert not queue.serve(Wire())


def test_more_requests_than_can_wait_are_refused():
    answers: list[dict[str, Any]] = []
    queue, wire = SdoQueue(BENCH, answers.append), Wire()
    for number in range(QUEUE + 1):
        queue.put(asked(number))
    refused = {"id": 64, "ok": False, "reason": "more than 64 SDO requests are waiting"}
    assert answers == [refused]
    queue.serve(wire)
    queue.put(asked(65))
    assert len(answers) == 2 and sum(queue.serve(wire) for _ in range(100)) == 64
