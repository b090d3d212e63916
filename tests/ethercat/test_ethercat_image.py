# SPDX-License-Identifier: Apache-2.0
"""Bytes of made-up slaves as numbers, commands as bytes; messages between the two processes."""

from __future__ import annotations

import socket

import pytest
from ethercat_rig import command, image

from flatplank_hw.bus.image import AXES, AxisCommand, AxisInputs, Digital
from flatplank_hw.ethercat.busfile import BusFile, Entry, Pdo, Slave
from flatplank_hw.ethercat.master import link
from flatplank_hw.ethercat.master.image import (
    BitPlace,
    CounterExtension,
    InputImage,
    OutputImage,
    expected_counter,
    place_bits,
)
from flatplank_hw.ethercat.reader import BusFileError

BITS = {"bool": 1, "": 8, "bit4": 4, "int8": 8, "uint16": 16, "int16": 16, "int32": 32,
        "uint32": 32}  # fmt: skip


def entry(channel: str, kind: str, bits: int = 0, **more) -> Entry:
    return Entry(0x6000 if kind else 0, 1, kind, bits or BITS[kind], "", channel, **more)


def slave(name: str, inputs=(), outputs=(), **more) -> Slave:
    pdos = {key: (Pdo(0x1A00, tuple(entries)),) if entries else ()
            for key, entries in (("inputs", inputs), ("outputs", outputs))}  # fmt: skip
    return Slave(name, "drive", 1, 2, 3, **pdos, **more)


FIVE_VOLTS = {"full_scale_volts": 5.0, "full_scale_counts": 20000}
BUS = BusFile("made up", (
    slave("coupler"),
    slave("plank", (
        entry("plank.status_word", "uint16"), entry("plank.torque", "int16", unit_nm=0.02),
        entry("plank.velocity", "int32"), entry("plank.error_code", "uint16"),
    ), (
        entry("plank.control_word", "uint16"), entry("", "", 8), entry("echo", "", 8),
        entry("plank.target_torque", "int16", unit_nm=0.02), entry("plank.mode", "int8"),
    )),
    slave("steer", (entry("steer.position", "int32"),),
          (entry("steer.target_position", "int32"), entry("steer.target_velocity", "int16"))),
    slave("volts", (entry("lvdt", "int16", **FIVE_VOLTS), entry("", "int16"),
                    entry("C6", "int16", full_scale_volts=10.0, full_scale_counts=1000))),
    slave("counts", (entry("wheel_counts", "uint16"), entry("road_counts", "uint32"))),
    slave("contacts", (entry("limit_rear", "bool"), entry("", "", 1), entry("trigger", "bool"))),
    slave("lamps", (), (entry("digital_outputs", "bit4"),)),
    slave("more", (entry("emergency_stop_ok", "bool"),), (entry("", "", 2),)),
))  # fmt: skip


def inputs_of(**data: bytes):
    """Input bytes by slave; zeros elsewhere. The bits of two slaves share a byte."""
    return [data.get(s.name, bytes((s.input_bits + 7) // 8)) for s in BUS.slaves]


def test_every_input_has_its_place_and_scale():
    contacts = b"\x0d"  # limit, nothing, trigger; then the contact of the next slave
    found = InputImage(BUS).decode(inputs_of(
        plank=b"\x34\x12" + (-300).to_bytes(2, "little", signed=True)
        + (-7).to_bytes(4, "little", signed=True) + b"\x10\x23",
        steer=(99).to_bytes(4, "little"), contacts=contacts, more=contacts,
        volts=(-1000).to_bytes(2, "little", signed=True) + b"\x77\x77" + b"\x64\x00",
        counts=b"\xff\xff" + b"\xfe\xff\xff\xff",
    ), 5, 6, 3)  # fmt: skip
    assert (found.cycle, found.stamp_ns, found.health) == (5, 6, 3)
    assert found.lvdt_volts == -0.25 and found.bridge_volts == (0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
    counts = (found.plank_counts, found.wheel_counts, found.steer_counts, found.camber_counts)
    assert counts == (0, 65535, 0, 0) and found.road_counts == -2
    assert found.digital == Digital.LIMIT_REAR | Digital.TRIGGER | Digital.EMERGENCY_STOP_OK
    nothing = AxisInputs(0, 0, 0, 0, 0, 0)
    plank, steer = AxisInputs(0x1234, 0, 0, -7, -60000, 0x2310), nothing._replace(position=99)
    assert found.axes == (nothing, plank, steer, nothing, nothing)


@pytest.mark.parametrize(
    ("byte", "digital"),
    [(0x00, 0), (0x01, Digital.LIMIT_REAR), (0x02, 0), (0x04, Digital.TRIGGER),
     (0x08, Digital.EMERGENCY_STOP_OK), (0xF0, 0)],
)  # fmt: skip
def test_every_contact_has_its_bit(byte, digital):
    data = inputs_of(contacts=bytes([byte]), more=bytes([byte]))
    assert InputImage(BUS).decode(data, 0, 0, 0).digital == digital


def test_counters_are_continued_from_cycle_to_cycle():
    decoder = InputImage(BUS)
    raw = (65535, 2, 65534, 30000, 60000, 20000)
    seen = [decoder.decode(inputs_of(counts=n.to_bytes(2, "little") + bytes(4)), 0, 0, 0)
            for n in raw]  # fmt: skip
    assert [i.wheel_counts for i in seen] == [65535, 65538, 65534, 95536, 125536, 151072]


@pytest.mark.parametrize(
    ("bits", "raw", "seen"),
    [(8, [0, 127, 254, 125], [0, 127, 254, 381]), (8, [0, 128], [0, -128]),
     (8, [5, 4, 255], [5, 4, -1]), (31, [2**31 - 1, 0], [2**31 - 1, -(2**31)]),
     (32, [2**31, 2**31 - 1], [-(2**31), 2**31 - 1]), (64, [2**32 + 3], [3])],
)  # fmt: skip
def test_a_counter_of_any_width(bits, raw, seen):
    """A step is less than half of its range; counts are int32 and wrap."""
    counter = CounterExtension(bits)
    assert [counter.extend(value) for value in raw] == seen


def test_every_command_has_its_place_scale_and_limit():
    out = OutputImage(BUS)
    assert out.echo == (1, 3)
    plank = AxisCommand(1, 1, 0x1234, -3, 55, 66, 40100, 0)
    steer = AxisCommand(2, 1, 7, 9, -5, 40000, 88, 0)
    rows = dict(out.encode([steer, plank], 0x1F, 0x2AB))
    assert rows == {
        1: b"\x34\x12\x00\xab" + (200).to_bytes(2, "little") + b"\xfd",
        2: (-5).to_bytes(4, "little", signed=True) + b"\xff\x7f",
        6: b"\x0f",  # four lamps; the two bits behind them carry nothing
        7: b"\x0f",
    }
    wild = plank._replace(control_word=-1, mode=200, target_torque=-(10**9))
    assert dict(out.encode([wild], -4, 0))[1] == b"\0\0\0\0\x00\x80\x7f"
    assert dict(out.encode([], 5, 0)) == {1: bytes(7), 2: bytes(6), 6: b"\x05", 7: b"\x05"}


@pytest.mark.parametrize(
    ("before", "bits", "echo"),
    [((), 8, (0, 0)), ((16,), 8, (0, 2)), ((4, 4), 8, (0, 1)), ((4,), 8, None), ((8,), 16, None)],
)
def test_the_echo_is_a_whole_byte(before, bits, echo):
    entries = [*(entry("", "", n) for n in before), entry("echo", "", bits)]
    assert OutputImage(BusFile("x", (slave("a", (), entries),))).echo == echo


def test_the_working_counter_of_a_good_cycle():
    """Three for a drive, one for inputs alone, two for outputs alone, none for a coupler."""
    assert [expected_counter(BusFile("x", (s,))) for s in BUS.slaves] == [0, 3, 3, 1, 1, 1, 2, 3]
    assert expected_counter(BUS) == 14


@pytest.mark.parametrize(
    ("lengths", "places"),
    [
        ([8, 16], [(0, 0, -1), (0, 0, -1)]), ([1, 7, 1], [(0, 1, 0), (1, 7, 0), (0, 1, 1)]),
        ([4, 0, 4, 1], [(0, 4, 0), (0, 0, -1), (4, 4, 0), (0, 1, 1)]),
        ([2, 8, 2], [(0, 2, 0), (0, 0, -1), (0, 2, 2)]), ([7], [(0, 7, 0)]), ([], []),
        ([8, 3], [(0, 0, -1), (0, 3, 1)]),
    ],
)  # fmt: skip
def test_where_the_bits_of_small_slaves_lie(lengths, places):
    found = [(p.shift, p.bits, p.group) for p in place_bits(lengths)]
    groups = [g for *_, g in found if g >= 0]
    assert [(s, b) for s, b, _ in found] == [(s, b) for s, b, _ in places]
    wanted = [g for *_, g in places if g >= 0]
    assert [groups.index(g) for g in groups] == [wanted.index(g) for g in wanted]


@pytest.mark.parametrize(("lengths", "number"), [([4, 5], 2), ([8, 7, 2], 3), ([1, 7, 4, 6], 4)])
def test_bits_that_would_cross_a_byte_are_refused(lengths, number):
    with pytest.raises(BusFileError, match=f"slave {number}: its {lengths[-1]} bits would cross"):
        place_bits(lengths)


def test_bits_are_taken_from_their_byte_and_put_into_it():
    place = BitPlace(3, 2, 5)
    assert [place.extract_bits(bytes([b])) for b in (0x18, 0x08, 0xE7)] == [b"\3", b"\1", b"\0"]
    assert place.extract_bits(b"") == b"" and BitPlace().extract_bits(b"\xff\xee") == b"\xff\xee"
    shared: dict[int, int] = {}
    assert place.insert_bits(b"\x02", shared) == b"\x10"
    assert BitPlace(0, 3, 5).insert_bits(b"\x05", shared) == b"\x15" and shared == {5: 0x15}
    assert BitPlace(0, 3, 6).insert_bits(b"\x05", shared) == b"\x05"
    assert BitPlace().insert_bits(b"\x07\x08", shared) == b"\x07\x08" and set(shared) == {5, 6}


# messages


@pytest.fixture
def ends():
    """The end of the bus process, and the two sockets of its client."""
    pairs = [socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET) for _ in range(2)]
    parent = link.ParentLink(*(here.detach() for here, _ in pairs))
    yield parent, *(there for _, there in pairs)
    for end in (parent._data, parent._control, *(there for _, there in pairs)):
        end.close()


def test_images_of_all_axes_come_through():
    axes = tuple(AxisInputs(n, -n, 2 * n, -3 * n, 4 * n, 5 * n) for n in range(1, len(AXES) + 1))
    numbers = dict(lvdt_volts=0.5, plank_counts=1, wheel_counts=2, steer_counts=3,
                   camber_counts=4, road_counts=5, digital=6, health=3)  # fmt: skip
    inputs = image()._replace(axes=axes, bridge_volts=(1.0, 2.0, 3.0, 4.0, 5.0, 6.0), **numbers)
    assert link.unpack_inputs(link.pack_inputs(inputs)) == inputs
    asked = AxisCommand(4, 5, 6, -7, -8, 9, -10, 11)
    assert link.unpack_command(link.pack_command(asked)) == asked


def test_what_goes_between_the_two_processes(ends):
    parent, data, control = ends
    assert parent.commands() == [] and parent.requests() == []
    for cycle in (1, 2):
        data.send(link.pack_command(command(7, cycle)))
        control.send(b'{"do": "stop", "id": %d}' % cycle)
    assert parent.commands() == [command(7, 1), command(7, 2)]
    assert [request["id"] for request in parent.requests()] == [1, 2]
    parent.publish(image())
    assert link.unpack_inputs(data.recv(link.MAX_MESSAGE)) == image()
    parent.send_message({"event": "ready"})
    assert control.recv(100) == b'{"event": "ready"}'
    assert not parent.parent_gone and parent.unread == 0


def test_images_that_nobody_reads_are_dropped_and_counted(ends):
    parent, data, _ = ends
    sent = 0
    while not parent.unread and sent < 10_000:
        parent.publish(image()._replace(cycle=sent))
        sent += 1
    parent.publish(image())
    assert parent.unread == 2 and not parent.parent_gone
    assert link.unpack_inputs(data.recv(link.MAX_MESSAGE)).cycle == 0


@pytest.mark.parametrize("end", ["data", "control", "publish"])
def test_a_closed_socket_is_a_parent_that_is_gone(ends, end):
    parent, data, control = ends
    data.send(link.pack_command(command()))
    (control if end == "control" else data).close()
    if end == "publish":
        parent.publish(image())
    elif end == "data":
        assert parent.commands() == [command()]
    else:
        assert parent.requests() == []
    assert parent.parent_gone and parent.commands() == [] and parent.unread == 0
