# SPDX-License-Identifier: Apache-2.0
"""Bus files value by value: what is read, what is written, how numbers lie in the process data."""

from __future__ import annotations

from typing import Any

import pytest
import yaml

from flatplank_hw.ethercat.busfile import (
    BusFile,
    Entry,
    Mailbox,
    Pdo,
    SdoValue,
    Slave,
    SyncManagers,
)
from flatplank_hw.ethercat.esi.numbers import EsiError, cia402_type, parse_number, type_of
from flatplank_hw.ethercat.layout import Layout, encode_value, range_of_type
from flatplank_hw.ethercat.reader import (
    BusFileError,
    check_integer,
    check_list,
    check_mapping,
    check_number,
    check_octets,
    parse_bus,
    parse_object,
    read_bus_file,
)
from flatplank_hw.ethercat.writer import write_bus

# how numbers lie


@pytest.mark.parametrize(
    ("kind", "span"),
    [("bool", (0, 1)), ("bit4", (0, 15)), ("uint8", (0, 255)), ("int8", (-128, 127)),
     ("uint16", (0, 65535)), ("int24", (-8388608, 8388607)), ("uint32", (0, 4294967295)),
     ("int32", (-2147483648, 2147483647)), ("int64", (-(2**63), 2**63 - 1))],
)  # fmt: skip
def test_the_range_of_a_type(kind, span):
    assert range_of_type(kind) == span


@pytest.mark.parametrize(
    ("kind", "value", "data"),
    [("string", "ä", b"\xc3\xa4"), ("octets", "01fF", b"\x01\xff"), ("bool", 1, b"\x01"),
     ("bit3", 9, b"\x01"), ("int16", -2, b"\xfe\xff"), ("uint24", 0x010203, b"\3\2\1"),
     ("uint16", 0x1FFFF, b"\xff\xff"), ("int64", -1, b"\xff" * 8), ("uint8", "7", b"\7")],
)  # fmt: skip
def test_a_value_as_bytes(kind, value, data):
    assert encode_value(kind, value) == data


@pytest.mark.parametrize(
    ("entries", "values", "data"),
    [
        ([("uint8", 8), ("int16", 16)], (255, -2), b"\xff\xfe\xff"),
        ([("", 8), ("uint16", 16)], (7, 258), b"\x07\x02\x01"),
        ([("bool", 1), ("bit3", 3), ("bool", 1)], (1, 5, 1), b"\x1b"),
        ([("bool", 1), ("", 7), ("int8", 8)], (1, 0, -3), b"\x01\xfd"),
        ([("bit4", 4), ("int24", 24)], (15, -2), b"\xef\xff\xff\x0f"),
        ([("", 16), ("uint8", 8)], (513, 3), b"\x01\x02\x03"),
        ([("uint24", 24)], (0x010203,), b"\x03\x02\x01"),
    ],
)
def test_numbers_lie_one_behind_the_other(entries, values, data):
    layout = Layout(entries)
    assert (layout.bits, layout.size) == (sum(bits for _, bits in entries), len(data))
    assert layout.pack(values) == data
    assert layout.unpack(data) == values == layout.unpack(data + b"\xff\xff")


# what is read


@pytest.mark.parametrize(
    ("value", "found"), [(0, 0), (5, 5), ("0x10", 16), ("10", 10), (4294967295, 4294967295)]
)
def test_whole_numbers(value, found):
    assert check_integer(value, "x") == found


@pytest.mark.parametrize(
    ("value", "said"),
    [(-1, "x: -1 is outside 0..4294967295"), (2**32, "is outside"), ("one", "x: 'one' is not a"),
     (1.0, "x: 1.0 is not a whole number"), (True, "True is not a whole"), (None, "None is not")],
)  # fmt: skip
def test_what_is_no_whole_number(value, said):
    with pytest.raises(BusFileError, match=said):
        check_integer(value, "x")


@pytest.mark.parametrize("value", [True, "1", None, float("inf"), float("nan"), [1]])
def test_what_is_no_number(value):
    assert check_number(2, "x") == 2.0 and check_number(-0.5, "x") == -0.5
    with pytest.raises(BusFileError, match="^x: .* is not a number"):
        check_number(value, "x")


def test_octets_lists_and_mappings():
    assert check_octets("0a ff", "x") == "0AFF"
    for wrong in ("0", "zz", 10, None):
        with pytest.raises(BusFileError, match="^x: .* must be hexadecimal digits in pairs"):
            check_octets(wrong, "x")
    assert check_list(None, "x") == [] and check_list(["a", 2], "x") == [("x[0]", "a"),
                                                                       ("x[1]", 2)]  # fmt: skip
    with pytest.raises(BusFileError, match="^x: expected a list, found dict"):
        check_list({}, "x")
    assert check_mapping({"a": 1}, "x", ("a", "b"), ("a",)) == {"a": 1}
    for wrong, said in ((3, "expected a mapping, found int"), ({"c": 1}, "unknown key 'c'"),
                        ({"b": 1}, "key 'a' is missing")):  # fmt: skip
        with pytest.raises(BusFileError, match=f"^x: {said}"):
            check_mapping(wrong, "x", ("a", "b"), ("a",))


@pytest.mark.parametrize(
    ("text", "place"),
    [("0x6040:1", (0x6040, 1)), ("0x6040", (0x6040, 0)), (0x6040, (0x6040, 0)),
     ("4096:255", (0x1000, 255)), ("0xFFFF:0x10", (0xFFFF, 16))],
)  # fmt: skip
def test_an_object(text, place):
    assert parse_object(text, "x") == place


@pytest.mark.parametrize("text", ["0xFFF:0", "0x10000", "0x6040:256", "0x6040:-1", "", "a:1"])
def test_what_is_no_object(text):
    with pytest.raises(BusFileError, match="^x: object"):
        parse_object(text, "x")


FULL = Slave(
    "drive", "drive", 0xB9, 0x1106, 1, check_revision=True, serial=7, placeholder="made up",
    axis="wheel", dc=True, mailbox=Mailbox(0x1200, 64, 0x1300, 32, False, False),
    sync_managers=SyncManagers(0x1100, 0x64, 0x1400, 0x20), write_assignment=True,
    write_mapping=True,
    outputs=(Pdo(0x1600, (
        Entry(0x6040, 0, "uint16", 16, "Control word", "wheel.control_word"),
        Entry(0, 0, "", 8, "padding", "echo"), Entry(0, 0, "", 16, "padding"),
        Entry(0x6071, 1, "int16", 16, "", "wheel.target_torque", unit_nm=0.02),
    ), "Outputs"), Pdo(0x1601, (), assigned=False)),
    inputs=(Pdo(0x1A00, (
        Entry(0x6000, 17, "int32", 32, "", "C1", full_scale_volts=10.0, full_scale_counts=8388607),
    )),),
    sdos=(SdoValue(0x605A, 0, "int16", -2, "Quick stop"), SdoValue(0x8000, 3, "string", "ab")),
    objects=(SdoValue(0x2000, 1, "octets", "01FF"), SdoValue(0x6502, 0, "uint64", 2**64 - 1)),
)  # fmt: skip
BUS = BusFile("made up", (Slave("coupler", "coupler", 2, 3, 4), FULL), 500, 20, 30)
WRITTEN: dict[str, Any] = {
    "format": "flatplank-bus/1", "name": "made up", "rate_hz": 500, "watchdog_ms": 20,
    "command_timeout_ms": 30,
    "slaves": [
        {"name": "coupler", "device": "coupler", "vendor": 2, "product": 3, "revision": 4},
        {
            "name": "drive", "device": "drive", "vendor": 0xB9, "product": 0x1106, "revision": 1,
            "check_revision": True, "placeholder": "made up", "axis": "wheel", "dc": True,
            "write_assignment": True, "write_mapping": True, "serial": 7,
            "mailbox": {"out_start": 0x1200, "out_size": 64, "in_start": 0x1300, "in_size": 32,
                        "complete_access": False, "sdo_info": False},
            "sync_managers": {"outputs_start": 0x1100, "outputs_control": 0x64,
                              "inputs_start": 0x1400, "inputs_control": 0x20},
            "outputs": [
                {"pdo": 0x1600, "name": "Outputs", "entries": [
                    {"object": "0x6040:0", "type": "uint16", "channel": "wheel.control_word",
                     "name": "Control word"},
                    {"pad": 8, "channel": "echo"}, {"pad": 16},
                    {"object": "0x6071:1", "type": "int16", "channel": "wheel.target_torque",
                     "unit_nm": 0.02},
                ]},
                {"pdo": 0x1601, "assigned": False, "entries": []},
            ],
            "inputs": [{"pdo": 0x1A00, "entries": [
                {"object": "0x6000:17", "type": "int32", "channel": "C1",
                 "full_scale_volts": 10.0, "full_scale_counts": 8388607},
            ]}],
            "sdos": [{"object": "0x605A:0", "type": "int16", "value": -2, "name": "Quick stop"},
                     {"object": "0x8000:3", "type": "string", "value": "ab"}],
            "objects": [{"object": "0x2000:1", "type": "octets", "value": "01FF"},
                        {"object": "0x6502:0", "type": "uint64", "value": 2**64 - 1}],
        },
    ],
}  # fmt: skip


def test_every_value_of_a_bus_file_is_written_and_read():
    assert yaml.safe_load(write_bus(BUS)) == WRITTEN
    assert parse_bus(WRITTEN) == BUS


@pytest.mark.parametrize(
    ("mailbox", "found", "written"),
    [(True, Mailbox(), True), (False, None, None), (None, None, None), ({}, Mailbox(), True)],
)
def test_a_mailbox_may_be_the_usual_one(mailbox, found, written):
    slave = {**WRITTEN["slaves"][0], "mailbox": mailbox}
    bus = parse_bus({**WRITTEN, "slaves": [slave]})
    assert bus.slaves[0].mailbox == found
    assert yaml.safe_load(write_bus(bus))["slaves"][0].get("mailbox") == written


def test_numbers_of_a_slave_are_written_as_makers_write_them():
    text = write_bus(BUS)
    assert text.startswith("# SPDX-License-Identifier: Apache-2.0\nformat: flatplank-bus/1\n")
    for line in ("vendor: 0x000000B9", "serial: 0x00000007", "- pdo: 0x00001600",
                 "{pad: 8, channel: echo}", "out_size: 0x00000040"):  # fmt: skip
        assert line in text
    assert all(len(line) <= 110 for line in text.splitlines())


@pytest.mark.parametrize(
    ("key", "low", "high"), [("rate_hz", 50, 2000), ("watchdog_ms", 5, 1000),
                             ("command_timeout_ms", 5, 1000)],
)  # fmt: skip
def test_the_ends_of_a_range(key, low, high):
    for value in (low, high):
        assert getattr(parse_bus({**WRITTEN, key: value}), key) == value
    for value in (low - 1, high + 1):
        with pytest.raises(BusFileError, match=f"{key}: {value} is outside {low}..{high}"):
            parse_bus({**WRITTEN, key: value})
    usual = parse_bus({k: v for k, v in WRITTEN.items() if k != key})
    assert getattr(usual, key) == {"rate_hz": 250, "watchdog_ms": 40}.get(key, 44)


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ({"pad": 0}, "pad: 0 is outside 1..64"), ({"pad": 65}, "pad: 65 is outside 1..64"),
        ({"object": "0x6000"}, "key 'type' is missing"), ({"type": "bool"}, "key 'object' is"),
        ({"object": "0x6000", "type": "string"}, "unknown type 'string'"),
        ({"object": "0x6000", "type": "bool", "colour": 1}, "unknown key 'colour'"),
        ({"object": "0x6000", "type": "int16", "channel": "C1", "full_scale_volts": 5.0},
         "channel 'C1' needs full_scale_volts and full_scale_counts"),
        ({"object": "0x6000", "type": "int16", "channel": "C1", "full_scale_counts": 5},
         "channel 'C1' needs full_scale_volts and full_scale_counts"),
        ({"object": "0x6000", "type": "int16", "channel": "plank.torque"}, "needs unit_nm"),
        ({"object": "0x6000", "type": "int16", "full_scale_counts": 2**31 + 1}, "is outside"),
    ],
)  # fmt: skip
def test_an_entry_that_says_too_little_is_refused_with_its_place(entry, said):
    slave = {**WRITTEN["slaves"][0], "inputs": [{"pdo": 0x1A00, "entries": [{"pad": 1}, entry]}]}
    with pytest.raises(BusFileError) as raised:
        parse_bus({**WRITTEN, "slaves": [slave]}, "my.yaml")
    place = "my.yaml: slaves[0] (coupler): inputs[0].entries[1]"
    assert str(raised.value).startswith(place) and said in str(raised.value)


@pytest.mark.parametrize(
    ("bits", "entry"),
    [(1, {"pad": 1}), (64, {"pad": 64}), (16, {"object": "0x6000", "type": "int16"})],
)
def test_the_length_of_an_entry(bits, entry):
    slave = {**WRITTEN["slaves"][0], "inputs": [{"pdo": 0x1BFF, "entries": [entry]}]}
    assert parse_bus({**WRITTEN, "slaves": [slave]}).slaves[0].input_bits == bits


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(BusFileError, match=r"gone.yaml: No such file or directory; give the path"):
        read_bus_file(tmp_path / "gone.yaml")


def test_only_assigned_data_are_exchanged():
    drive = BUS.slave("drive")
    assert (drive.output_bits, drive.input_bits) == (16 + 8 + 16 + 16, 32)
    bare = Slave("x", "drive", 1, 2, 3)
    assert bare.memory == SyncManagers(0x0F00, 0x44, 0x1000, 0x00)
    with_mailbox = Slave("x", "drive", 1, 2, 3, mailbox=Mailbox())
    assert with_mailbox.memory == SyncManagers(0x1100, 0x64, 0x1400, 0x20)
    assert drive.memory is drive.sync_managers and BUS.period_ns == 2_000_000
    assert Entry(0x6040, 2, "uint16", 16).mapping_word == 0x60400210
    assert Pdo(0x1600, (Entry(0, 0, "", 3), Entry(0, 0, "", 5))).bits == 8


# numbers and types of device descriptions


@pytest.mark.parametrize(
    ("text", "value"),
    [("26", 26), (" 0026 ", 26), ("+7", 7), ("#x1A", 26), ("0x1a", 26), ("#XFFFFFFFF", 2**32 - 1)],
)
def test_a_number_of_a_device_description(text, value):
    assert parse_number(text, "x") == value


@pytest.mark.parametrize(
    ("text", "said"),
    [(None, "x is missing"), ("  ", "x is missing"), ("1A", "x is '1A', not a number"),
     ("-1", "x is '-1', not a number"), ("256", "x is 256, must be within 0 .. 255"),
     ("ab  c" * 30, f"x is '{'ab c' * 10}', not")],
)  # fmt: skip
def test_what_is_no_number_of_a_device_description(text, said):
    assert parse_number("255", "x", 255) == 255
    with pytest.raises(EsiError) as raised:
        parse_number(text, "x", 255)
    assert str(raised.value).startswith(said)


@pytest.mark.parametrize(
    ("index", "subindex", "kind"),
    [(0x6040, 0, "uint16"), (0x6040, 1, ""), (0x6840, 0, "uint16"), (0x9840, 0, "uint16"),
     (0xA040, 0, ""), (0x607A, 0, "int32"), (0x687A, 0, "int32"), (0x2000, 0, ""),
     (0x6502, 0, "uint32"), (0x6000, 0, ""), (0x5FFF, 0, "")],
)  # fmt: skip
def test_the_type_of_an_object_of_a_drive(index, subindex, kind):
    assert cia402_type(index, subindex) == kind


@pytest.mark.parametrize(
    ("raw", "bits", "found"),
    [("DINT", 32, ("int32", True)), ("dint", 32, ("int32", True)), ("U INT", 16, ("uint16", True)),
     ("MINE", 16, ("uint16", False)), ("", 1, ("bool", False)), ("", 7, ("bit7", False)),
     ("BITARR8", 8, ("uint8", True)), ("BIT", 1, ("bool", True))],
)  # fmt: skip
def test_the_type_of_an_object_by_its_text_and_length(raw, bits, found):
    assert type_of(raw, bits, "x") == found


@pytest.mark.parametrize(
    ("raw", "bits", "said"),
    [("DINT", 16, "x has 16 bits, its type DINT has 32 bits"),
     ("MINE", 12, "x has type 'MINE' of 12 bits, which is not known")],
)  # fmt: skip
def test_a_type_that_contradicts_its_length(raw, bits, said):
    with pytest.raises(EsiError) as raised:
        type_of(raw, bits, "x")
    assert str(raised.value).startswith(said)
