# SPDX-License-Identifier: Apache-2.0
"""The frame engine on bytes: commands, addresses, working counters, FMMUs, sync managers."""

from __future__ import annotations

import pytest
from ethercat_rig import BUS_FILES
from ethercat_stub_plant import StubPlant

from flatplank_hw.ethercat.reader import read_bus_file
from flatplank_sim.emulator.bench import EmulatedBench
from flatplank_sim.emulator.esc import SlaveController
from flatplank_sim.emulator.frame import Command, FrameError, split
from flatplank_sim.emulator.registers import Fmmu, read_fmmus
from flatplank_sim.emulator.segment import Segment
from flatplank_sim.emulator.wire import Wire

SLAVES = 5


def build(datagrams: list[tuple[int, int, int, bytes]], index: int = 0) -> bytearray:
    """A frame from (command, address 16 low bits or whole, register offset, data).

    For logical commands the second number is the 32-bit address and the third is ignored.
    """
    body = bytearray()
    for position, (command, address, offset, data) in enumerate(datagrams):
        logical = command in (Command.LRD, Command.LWR, Command.LRW)
        word = address if logical else (address & 0xFFFF) | offset << 16
        more = 0x8000 if position + 1 < len(datagrams) else 0
        body += bytes([command, index]) + word.to_bytes(4, "little")
        body += (len(data) | more).to_bytes(2, "little") + b"\0\0" + data + b"\0\0"
    head = b"\xff" * 6 + b"\x01\x01\x01\x01\x01\x01" + b"\x88\xa4"
    return bytearray(head + (len(body) | 0x1000).to_bytes(2, "little") + body)


def results(frame: bytes | bytearray) -> list[tuple[bytes, int]]:
    """(data, working counter) of each datagram of an answer."""
    out = []
    for datagram in split(frame):
        counter = datagram.counter
        data = bytes(frame[datagram.data : counter])
        out.append((data, frame[counter] | frame[counter + 1] << 8))
    return out


@pytest.fixture
def bench() -> EmulatedBench:
    return EmulatedBench(read_bus_file(BUS_FILES / "minimal.yaml"), StubPlant(250))


@pytest.fixture
def segment(bench: EmulatedBench) -> Segment:
    for position in range(SLAVES):
        ask(
            bench.segment,
            Command.APWR,
            -position,
            0x0010,
            (0x1001 + position).to_bytes(2, "little"),
        )
    return bench.segment


def ask(
    segment: Segment, command: int, address: int, offset: int, data: bytes
) -> tuple[bytes, int]:
    """One datagram through the segment: data and working counter."""
    return results(segment.process(bytes(build([(command, address, offset, data)])), 0))[0]


def fmmu(logical: int, length: int, bits: tuple[int, int], physical: int, kind: int) -> bytes:
    """Registers of a unit."""
    raw = logical.to_bytes(4, "little") + length.to_bytes(2, "little") + bytes(bits)
    return raw + physical.to_bytes(2, "little") + bytes([0, kind, 1, 0, 0, 0])


def test_broadcast_counts_the_slaves(segment: Segment) -> None:
    data, counter = ask(segment, Command.BRD, 0, 0x0000, b"\0")
    assert counter == SLAVES and data == b"\x11"
    assert ask(segment, Command.BWR, 0, 0x0100, b"\x01")[1] == SLAVES


def test_broadcast_read_ors(segment: Segment) -> None:
    for position in range(SLAVES):
        ask(segment, Command.FPWR, 0x1001 + position, 0x0F80, bytes([1 << position]))
    assert ask(segment, Command.BRD, 0, 0x0F80, b"\0") == (b"\x1f", SLAVES)


@pytest.mark.parametrize("position", range(SLAVES))
def test_auto_increment_reaches_one(segment: Segment, position: int) -> None:
    data, counter = ask(segment, Command.APRD, -position, 0x0010, b"\0\0")
    assert counter == 1 and int.from_bytes(data, "little") == 0x1001 + position


def test_every_slave_adds_one_to_the_position(segment: Segment) -> None:
    frame = segment.process(bytes(build([(Command.APRD, 0, 0, b"\0")])), 0)
    assert int.from_bytes(frame[18:20], "little") == SLAVES


def test_station_address(segment: Segment) -> None:
    assert ask(segment, Command.FPRD, 0x1003, 0x0010, b"\0\0") == (b"\x03\x10", 1)
    assert ask(segment, Command.FPRD, 0x2000, 0x0010, b"\x55\x55") == (b"\x55\x55", 0)


@pytest.mark.parametrize(
    ("command", "address", "counter"),
    [
        (Command.APRW, 0, 3),
        (Command.FPRW, 0x1001, 3),
        (Command.BRW, 0, 3 * SLAVES),
        (Command.APWR, 0, 1),
        (Command.FPWR, 0x1001, 1),
        (Command.ARMW, -2, SLAVES),
        (Command.FRMW, 0x1003, SLAVES),
        (Command.NOP, 0, 0),
    ],
)
def test_working_counters(segment: Segment, command: int, address: int, counter: int) -> None:
    assert ask(segment, command, address, 0x0F80, b"\x07")[1] == counter


@pytest.mark.parametrize(("command", "address"), [(Command.ARMW, -2), (Command.FRMW, 0x1003)])
def test_one_reads_all_others_write(segment: Segment, command: int, address: int) -> None:
    """Slaves before the reader get what the master sent, those behind what was read."""
    ask(segment, Command.FPWR, 0x1003, 0x0F80, b"\x2a")
    ask(segment, command, address, 0x0F80, b"\x11")
    found = [ask(segment, Command.FPRD, 0x1001 + i, 0x0F80, b"\0")[0][0] for i in range(SLAVES)]
    assert found == [0x11, 0x11, 0x2A, 0x2A, 0x2A]


def test_several_datagrams_in_one_frame(segment: Segment) -> None:
    frame = build(
        [
            (Command.BRD, 0, 0x0000, b"\0"),
            (Command.FPRD, 0x1002, 0x0010, b"\0\0"),
            (Command.FPRD, 0x7777, 0x0010, b"\0\0"),
        ]
    )
    assert results(segment.process(bytes(frame), 0)) == [
        (b"\x11", 5),
        (b"\x02\x10", 1),
        (b"\0\0", 0),
    ]


def test_memory_that_is_not_there(segment: Segment) -> None:
    assert ask(segment, Command.FPRD, 0x1001, 0x2FFF, b"\0\0")[1] == 0
    assert ask(segment, Command.FPWR, 0x1001, 0xFFFF, b"\0\0")[1] == 0


def test_status_registers_cannot_be_written(segment: Segment) -> None:
    before = ask(segment, Command.FPRD, 0x1001, 0x0110, b"\0\0")[0]
    ask(segment, Command.FPWR, 0x1001, 0x0110, b"\xff\xff")
    ask(segment, Command.FPWR, 0x1001, 0x0130, b"\xff\xff")
    assert ask(segment, Command.FPRD, 0x1001, 0x0110, b"\0\0")[0] == before
    assert ask(segment, Command.FPRD, 0x1001, 0x0130, b"\0\0")[0] == b"\x01\0"


def test_source_address_tells_that_slaves_were_passed(segment: Segment) -> None:
    frame = bytes(build([(Command.NOP, 0, 0, b"\0")]))
    assert segment.process(frame, 0)[6] == frame[6] | 0x02


def test_topology_follows_the_cable(bench: EmulatedBench) -> None:
    def ends() -> list[bool]:
        return [s.esc.read_register(0x0110) & 0x0C00 == 0x0400 for s in bench.slaves]

    assert ends() == [False] * 4 + [True]
    bench.segment.cut_after = 2
    bench.segment.show_topology()
    assert ends()[:2] == [False, True]
    assert ask(bench.segment, Command.BRD, 0, 0, b"\0")[1] == 2
    bench.segment.cut_after = 0
    assert bench.segment.process(bytes(build([(Command.BRD, 0, 0, b"\0")])), 0) is None


@pytest.mark.parametrize(
    "spoil",
    [
        lambda f: f[:20],
        lambda f: f[:12] + b"\x08\x00" + f[14:],
        lambda f: f[:15] + b"\x40" + f[16:],
        lambda f: f[:22] + b"\xff\x07" + f[24:],
        lambda f: f[:22] + b"\x01\x80" + f[24:],
        lambda f: b"",
    ],
    ids=["cut", "other protocol", "other type", "too long", "more that is not there", "empty"],
)
def test_malformed_frames_are_lost(segment: Segment, spoil) -> None:
    frame = spoil(bytes(build([(Command.BRD, 0, 0, b"\0")])))
    before = segment.rejected
    assert segment.process(frame, 0) is None and segment.rejected == before + 1
    with pytest.raises(FrameError):
        split(frame)


def test_random_bytes_never_break_the_engine(bench: EmulatedBench) -> None:
    """Any datagram with any content is served or ignored."""
    import random

    rng = random.Random(5)
    for _ in range(3000):
        grams = [
            (
                rng.randrange(16),
                rng.getrandbits(32),
                rng.getrandbits(16),
                rng.randbytes(rng.randrange(1, 40)),
            )
            for _ in range(rng.randrange(1, 4))
        ]
        bench.frame(bytes(build(grams)))
    for _ in range(500):
        bench.frame(b"\xff" * 12 + b"\x88\xa4" + rng.randbytes(rng.randrange(2, 80)))


# --- logical addressing -------------------------------------------------------------------


def opened(units: bytes, memory: dict[int, bytes] | None = None) -> SlaveController:
    """A controller with FMMUs and process data on."""
    esc = SlaveController()
    esc.process_data_on = True
    esc._write(0x0600, units)
    for address, data in (memory or {}).items():
        esc.memory[address : address + len(data)] = data
    return esc


def logical(esc: SlaveController, command: int, address: int, data: bytes) -> tuple[bytes, int]:
    frame = build([(command, address, 0, data)])
    d = split(frame)[0]
    counter = esc.execute(d.command, frame, d.start, d.length)
    return bytes(frame[d.data : d.counter]), counter


BOTH = fmmu(0x100, 4, (0, 7), 0x1100, 2) + fmmu(0x104, 2, (0, 7), 0x1400, 1)


@pytest.mark.parametrize(
    ("command", "counter", "written", "read"),
    [(Command.LRW, 3, True, True), (Command.LRD, 1, False, True), (Command.LWR, 1, True, False)],
)
def test_logical_commands(command: int, counter: int, written: bool, read: bool) -> None:
    esc = opened(BOTH, {0x1400: b"\xab\xcd"})
    data, grown = logical(esc, command, 0x100, b"\x01\x02\x03\x04\0\0")
    assert grown == counter
    assert (esc.memory[0x1100:0x1104] == b"\x01\x02\x03\x04") is written
    assert (data[4:] == b"\xab\xcd") is read and data[:4] == b"\x01\x02\x03\x04"


def test_logical_outside_or_in_part() -> None:
    esc = opened(BOTH, {0x1400: b"\xab\xcd"})
    assert logical(esc, Command.LRW, 0x200, b"\0\0")[1] == 0
    assert logical(esc, Command.LRW, 0x105, b"\0\0") == (b"\xcd\0", 1)
    assert logical(esc, Command.LRW, 0x0FE, b"\x09\x09\x07\x08") == (b"\x09\x09\x07\x08", 2)
    assert esc.memory[0x1100:0x1102] == b"\x07\x08"


def test_process_data_only_from_safeop_on() -> None:
    esc = opened(BOTH)
    esc.process_data_on = False
    assert logical(esc, Command.LRW, 0x100, bytes(6))[1] == 0


@pytest.mark.parametrize("start", range(5))
def test_bits_of_small_slaves(start: int) -> None:
    """Four input bits at any place of a byte; the others stay as they are."""
    esc = opened(fmmu(0x10, 1, (start, start + 3), 0x1000, 1), {0x1000: b"\x05"})
    data, counter = logical(esc, Command.LRW, 0x10, b"\xff")
    assert counter == 1 and data[0] == (0xFF & ~(0x0F << start)) | 0x05 << start


def test_output_bits_do_not_touch_their_neighbours() -> None:
    esc = opened(fmmu(0x10, 1, (2, 4), 0x0F00, 2), {0x0F00: b"\xf8"})
    assert logical(esc, Command.LRW, 0x10, b"\x14")[1] == 2
    assert esc.memory[0x0F00] == 0xF8 | 0b101


def test_unused_fmmus_are_ignored() -> None:
    off = bytearray(fmmu(0, 4, (0, 7), 0x1000, 1))
    off[12] = 0
    assert read_fmmus(bytes(off) + bytes(16)) == []
    assert read_fmmus(fmmu(1, 2, (0, 7), 3, 1)) == [Fmmu(1, 2, 0, 7, 3, 0, 1)]


# --- sync managers in mailbox mode --------------------------------------------------------


def mailbox() -> SlaveController:
    esc = SlaveController()
    managers = b"\x00\x10\x10\x00\x26\x00\x01\x00" + b"\x80\x10\x10\x00\x22\x00\x01\x00"
    esc._write(0x0800, managers)
    return esc


def test_mailbox_takes_whole_messages_one_at_a_time() -> None:
    esc = mailbox()
    got: list[bytes] = []
    esc.mailbox_received = got.append
    assert not esc._write(0x1004, bytes(4)), "must begin at the start"
    assert esc._write(0x1000, b"A" * 8) and not got, "not full yet"
    assert esc._write(0x1000, b"B" * 16) and got == [b"B" * 16]
    assert esc.memory[0x0805] & 8 and not esc._write(0x1000, b"C" * 16)
    esc.take_mailbox()
    assert not esc.memory[0x0805] & 8 and esc._write(0x1000, b"D" * 16)


def test_mailbox_is_read_once_and_repeated_on_request() -> None:
    esc = mailbox()
    assert esc._read(0x1080, 16) is None
    assert esc.offer_mailbox(b"hello") and not esc.offer_mailbox(b"again")
    assert esc.memory[0x080D] & 8
    assert esc._read(0x1080, 16) == b"hello".ljust(16, b"\0")
    assert esc._read(0x1080, 16) is None
    esc._write(0x080E, b"\x03")
    assert esc.memory[0x080F] & 2, "repeat acknowledged"
    assert esc._read(0x1080, 16) == b"hello".ljust(16, b"\0")


def test_a_new_configuration_forgets_old_mail() -> None:
    esc = mailbox()
    esc.offer_mailbox(b"old")
    esc._write(0x0800, bytes(32))
    assert not esc.memory[0x080D] & 8


# --- the wire -----------------------------------------------------------------------------


def test_wire_drops_what_is_old() -> None:
    wire = Wire(max_age_ns=5_000_000)
    assert wire.admits(True, 4_999_999) and not wire.admits(True, 5_000_001)
    assert wire.counts["aged"] == 1


def test_wire_counts_what_the_master_may_miss_the_answer_to() -> None:
    """Two milliseconds were no stall, which counts from 3 ms on, and four lost frames a fault of
    the master."""
    wire = Wire()
    assert all(wire.admits(True, age) for age in (0, 1_400_000, 1_600_000, 2_500_000))
    assert (wire.counts["late"], wire.counts["aged"]) == (2, 0)


def test_wire_loses_holds_and_delays() -> None:
    wire = Wire()
    wire.lose_next = 1
    assert not wire.admits(True, 0) and wire.admits(True, 0) and wire.admits(False, 0)
    frame = bytearray(b"x")
    wire.lose_answers = 1
    assert wire.answer(frame, True, 0) == [] and wire.answer(frame, True, 0) == [frame]
    wire.holding = True
    assert wire.answer(frame, True, 0) == [] and wire.answer(frame, False, 0) == [frame]
    assert wire.answer(frame, True, 0) == []
    wire.release()
    assert wire.due(1) == [frame, frame] and wire.next_due is None
    wire.delay_ns = 1000
    assert wire.answer(frame, True, 5) == [] and wire.next_due == 1005
    assert wire.due(1004) == [] and wire.due(1005) == [frame]
    wire.delay_ns, wire.down = 0, True
    assert not wire.admits(False, 0)


def test_wire_loses_its_share() -> None:
    wire = Wire(seed=3, lose_share=0.1)
    passed = sum(wire.admits(True, 0) for _ in range(5000))
    assert 4400 < passed < 4600
