# SPDX-License-Identifier: Apache-2.0
"""CoE on bytes: transfers of every kind, complete access, PDO lists, information service,
emergencies."""

from __future__ import annotations

import pytest
from ethercat_rig import BUS_FILES

from flatplank_hw.ethercat.reader import read_bus_file
from flatplank_sim.emulator.al import State
from flatplank_sim.emulator.dictionary import Dictionary, variable
from flatplank_sim.emulator.mailbox import Mailbox
from flatplank_sim.emulator.sdo import SdoInfo, SdoServer
from flatplank_sim.emulator.slave import EmulatedSlave

ROOM = 128


@pytest.fixture
def dictionary() -> Dictionary:
    d = Dictionary()
    d.add(0x2000, 0, variable("uint16", 0x1234, "short", writable=True))
    d.add(0x2001, 0, variable("uint64", 0x0102030405060708, "eight", writable=True))
    d.add(0x2002, 0, variable("string", "x" * 1000, "long", writable=True))
    d.add(0x2003, 0, variable("uint8", 5, "fixed"))
    for sub, value in enumerate((11, 22, 33), 1):
        d.add(0x2100, sub, variable("uint16", value, f"part {sub}", writable=True), "record")
    return d


@pytest.fixture
def server(dictionary: Dictionary) -> SdoServer:
    return SdoServer(dictionary, ROOM)


def address(index: int, sub: int = 0) -> bytes:
    return index.to_bytes(2, "little") + bytes([sub])


def upload(server: SdoServer, index: int, sub: int = 0, complete: bool = False) -> bytes:
    """A whole upload as a master does it."""
    answer = server.serve(bytes([0x40 | 0x10 * complete]) + address(index, sub) + bytes(4))
    assert answer[1:4] == address(index, sub)
    if answer[0] == 0x80:
        raise ValueError(hex(int.from_bytes(answer[4:8], "little")))
    if answer[0] & 2:
        return answer[4 : 8 - (answer[0] >> 2 & 3)]
    size = int.from_bytes(answer[4:8], "little")
    data, toggle = answer[8:], 0
    while len(data) < size:
        segment = server.serve(bytes([0x60 | toggle]) + bytes(7))
        assert segment[0] & 0xF0 == toggle and len(segment) <= ROOM - 8
        data += segment[1:8][: 7 - (segment[0] >> 1 & 7)] if len(segment) == 8 else segment[1:]
        toggle ^= 0x10
        assert (segment[0] & 1) == (len(data) >= size)
    return data


def download(
    server: SdoServer, index: int, data: bytes, sub: int = 0, complete: bool = False
) -> None:
    """A whole download as a master does it."""
    mode = 0x10 * complete
    if len(data) <= 4:
        head = bytes([0x23 | mode | (4 - len(data)) << 2])
        answer = server.serve(head + address(index, sub) + data.ljust(4, b"\0"))
        rest = b""
    else:
        room = ROOM - 16
        size = len(data).to_bytes(4, "little")
        answer = server.serve(bytes([0x21 | mode]) + address(index, sub) + size + data[:room])
        rest = data[room:]
    toggle = 0
    while answer[0] != 0x80 and rest:
        part, rest = rest[: ROOM - 9], rest[ROOM - 9 :]
        unused = max(7 - len(part), 0)
        head = bytes([toggle | unused << 1 | (0 if rest else 1)])
        answer = server.serve(head + part.ljust(7, b"\0"))
        toggle ^= 0x10
    if answer[0] == 0x80:
        raise ValueError(hex(int.from_bytes(answer[4:8], "little")))


@pytest.mark.parametrize(
    "size", [1, 2, 3, 4, 5, 7, 8, 100, 111, 112, 113, 119, 231, 232, 600, 1000]
)
def test_transfers_of_any_length(server: SdoServer, size: int) -> None:
    data = bytes(i % 251 for i in range(size))
    download(server, 0x2002, data)
    assert upload(server, 0x2002) == data


@pytest.mark.parametrize(
    ("index", "sub", "data", "code"),
    [
        (0x2999, 0, b"\0\0", 0x06020000),
        (0x2100, 9, b"\0\0", 0x06090011),
        (0x2003, 0, b"\0", 0x06010002),
        (0x2000, 0, b"\0\0\0", 0x06070010),
    ],
)
def test_refused_downloads(
    server: SdoServer, index: int, sub: int, data: bytes, code: int
) -> None:
    with pytest.raises(ValueError, match=f"0x{code:x}"):
        download(server, index, data, sub)


def test_refused_uploads(server: SdoServer) -> None:
    with pytest.raises(ValueError, match="0x6020000"):
        upload(server, 0x2999)
    with pytest.raises(ValueError, match="0x6010004"):
        upload(server, 0x2000, complete=True)
    assert server.serve(bytes([0x60]) + bytes(7))[0] == 0x80, "segment that nobody began"
    assert server.serve(bytes([0xA0]) + bytes(7))[0] == 0x80, "unknown command"
    assert server.serve(bytes([0x80]) + bytes(7)) == b"", "an abort is not answered"


def test_wrong_toggle_bit(server: SdoServer) -> None:
    server.serve(bytes([0x40]) + address(0x2002) + bytes(4))
    answer = server.serve(bytes([0x70]) + bytes(7))
    assert answer[0] == 0x80 and int.from_bytes(answer[4:8], "little") == 0x05030000


def test_complete_access(server: SdoServer) -> None:
    assert upload(server, 0x2100, 0, complete=True) == bytes([3, 0, 11, 0, 22, 0, 33, 0])
    assert upload(server, 0x2100, 1, complete=True) == bytes([11, 0, 22, 0, 33, 0])
    download(server, 0x2100, bytes([3, 0, 1, 0, 2, 0, 3, 0]), 0, complete=True)
    assert [upload(server, 0x2100, sub) for sub in (1, 2, 3)] == [b"\x01\0", b"\x02\0", b"\x03\0"]


def test_abort_by_fault(server: SdoServer) -> None:
    server.abort_all = 0x08000000
    with pytest.raises(ValueError, match="0x8000000"):
        upload(server, 0x2000)


# --- mailbox ------------------------------------------------------------------------------


class Master:
    """The other side of a mailbox."""

    def __init__(self, dictionary: Dictionary) -> None:
        self.inbox: list[bytes] = []
        self.room = True
        self.mailbox = Mailbox(dictionary, ROOM, self.take)

    def take(self, message: bytes) -> bool:
        if self.room:
            self.inbox.append(message)
        return self.room

    def send(self, kind: int, body: bytes) -> None:
        self.mailbox.request(len(body).to_bytes(2, "little") + bytes([0, 0, 0, kind]) + body)


def test_emergency_and_order(dictionary: Dictionary) -> None:
    master = Master(dictionary)
    master.room = False
    master.mailbox.emergency(0x2310, 1, b"\x07")
    master.send(3, b"\x00\x20" + bytes([0x40]) + address(0x2000) + bytes(4))
    assert master.inbox == []
    master.room = True
    master.mailbox.offer_next(0)
    first, second = master.inbox
    assert first[6:] == b"\x00\x10\x10\x23\x01\x07\0\0\0\0" and second[7] >> 4 == 3
    assert first[5] >> 4 != second[5] >> 4, "the counter moves on"


def test_late_and_hanging_mailbox(dictionary: Dictionary) -> None:
    master = Master(dictionary)
    request = b"\x00\x20" + bytes([0x40]) + address(0x2000) + bytes(4)
    master.mailbox.late_ns = 1000
    master.mailbox.offer_next(500)
    master.send(3, request)
    master.mailbox.offer_next(1499)
    assert master.inbox == []
    master.mailbox.offer_next(1500)
    assert len(master.inbox) == 1
    master.mailbox.hang = True
    master.send(3, request)
    master.mailbox.offer_next(10**9)
    assert len(master.inbox) == 1


def test_abort_travels_as_a_request(dictionary: Dictionary) -> None:
    master = Master(dictionary)
    master.send(3, b"\x00\x20" + bytes([0x40]) + address(0x2999) + bytes(4))
    assert master.inbox[0][7] >> 4 == 2 and master.inbox[0][8] == 0x80


def test_other_protocols_are_refused(dictionary: Dictionary) -> None:
    master = Master(dictionary)
    master.send(4, b"\0\0\0\0")
    assert master.inbox[0][5] & 0x0F == 0 and master.inbox[0][6:10] == b"\x01\0\x02\0"


# --- information service ------------------------------------------------------------------


def test_object_list_in_fragments() -> None:
    d = Dictionary()
    for i in range(200):
        d.add(0x3000 + i, 0, variable("uint8", 0, f"object {i}"))
    parts = SdoInfo(d, ROOM).serve(b"\x01\0\0\0\x01\0")
    assert len(parts) > 1
    left = [int.from_bytes(p[2:4], "little") for p in parts]
    assert left == list(range(len(parts) - 1, -1, -1))
    assert [bool(p[0] & 0x80) for p in parts] == [True] * (len(parts) - 1) + [False]
    body = b"".join(p[4:] for p in parts)[2:]
    assert [int.from_bytes(body[i : i + 2], "little") for i in range(0, 400, 2)] == sorted(
        d.objects
    )


def test_descriptions(dictionary: Dictionary) -> None:
    info = SdoInfo(dictionary, ROOM)
    record = info.serve(b"\x03\0\0\0\x00\x21")[0]
    assert record[4:6] == b"\x00\x21" and record[8] == 3 and record[10:] == b"record"
    entry = info.serve(b"\x05\0\0\0\x00\x21\x02\x07")[0]
    assert entry[8:12] == b"\x06\0\x10\0" and entry[14:] == b"part 2"
    for request in (b"\x03\0\0\0\x99\x29", b"\x05\0\0\0\x00\x21\x09\x07", b"\x0b\0\0\0\0\0"):
        assert info.serve(request)[0][0] & 0x7F == 7


# --- PDO assignment and mapping of a real slave -------------------------------------------


@pytest.fixture
def slave() -> EmulatedSlave:
    made = EmulatedSlave(read_bus_file(BUS_FILES / "bench.yaml").slave("bridges_a"))
    made.al.state = State.PREOP
    return made


def test_assignment_changes_the_process_data(slave: EmulatedSlave) -> None:
    server = slave.mailbox.sdo
    assert slave.inputs.layout.size == 16
    download(server, 0x1C13, b"\0")
    download(server, 0x1C13, b"\x02\x1a", 1)
    download(server, 0x1C13, b"\x01")
    assert slave.inputs.layout.size == 4 and slave.inputs.entries[0].channel == "C3"
    download(server, 0x1C13, bytes([2, 0, 0, 0x1A, 3, 0x1A]), 0, complete=True)
    assert [e.channel for e in slave.inputs.entries] == ["C1", "C4"]
    assert upload(server, 0x1C13, 0, complete=True) == bytes([2, 0, 0, 0x1A, 3, 0x1A])


def test_assignment_is_refused_when_it_cannot_be(slave: EmulatedSlave) -> None:
    server = slave.mailbox.sdo
    with pytest.raises(ValueError, match="0x8000022"):
        download(server, 0x1C13, b"\x02\x1a", 1)
    download(server, 0x1C13, b"\0")
    download(server, 0x1C13, b"\x77\x1a", 1)
    with pytest.raises(ValueError, match="0x6040041"):
        download(server, 0x1C13, b"\x01")
    slave.al.state = State.OP
    with pytest.raises(ValueError, match="0x8000022"):
        download(server, 0x1C13, b"\0")


def test_power_cycle_forgets_the_assignment(slave: EmulatedSlave) -> None:
    download(slave.mailbox.sdo, 0x1C13, b"\0")
    assert slave.inputs.layout.size == 0
    slave.power_on()
    assert slave.inputs.layout.size == 16 and slave.al.state == State.INIT
