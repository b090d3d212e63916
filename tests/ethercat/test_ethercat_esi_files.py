# SPDX-License-Identifier: Apache-2.0
"""Device descriptions as makers write them: types, numbers, alternatives, start-up commands; and
damaged ones.
"""

from __future__ import annotations

import struct
from pathlib import Path

import pytest
from ethercat_rig import BUS_FILES

from flatplank_hw.ethercat.busfile import Slave
from flatplank_hw.ethercat.esi import EsiError, merge_device, read_esi
from flatplank_hw.ethercat.esi.__main__ import main
from flatplank_hw.ethercat.esi.numbers import CIA402_TYPES, cia402_type, parse_number
from flatplank_hw.ethercat.layout import TYPES, Layout, encode_value
from flatplank_hw.ethercat.reader import BusFileError, parse_bus, read_bus_file
from flatplank_hw.ethercat.writer import write_bus
from flatplank_validation.trust.esi_damage import drive_file, entry
from flatplank_validation.trust.registry import Options
from flatplank_validation.trust.rows.esi import damaged_esi

KINDS = {
    "DINT": ("INT32", "INTEGER32", "UDINT", "UINT32", "UNSIGNED32", "dint", "DWORD", "REAL", ""),
    "INT": ("INT16", "INTEGER16", "UINT", "WORD", ""),
    "UINT": ("UINT16", "UNSIGNED16", "INT16", "WORD", ""),
    "SINT": ("INT8", "INTEGER8", "USINT", "BYTE", ""),
}
"""type of ETG.2000 -> what makers write for an object of that type"""
COMMAND = (
    "<InitCmd{0}><Transition>{1}</Transition><Index>#x2005</Index>{2}<Data>{3}</Data></InitCmd>"
)


def merged(tmp_path: Path, text: str) -> Slave:
    """The wheel drive of the bench with the device of a file; through a written bus file."""
    path = tmp_path / "maker.xml"
    path.write_text(text)
    (device,) = read_esi(path)
    bus = merge_device(read_bus_file(BUS_FILES / "bench.yaml"), "wheel_drive", device, 5.0)
    out = tmp_path / "new.yaml"
    out.write_text(write_bus(bus))
    assert read_bus_file(out) == bus
    return bus.slave("wheel_drive")


def notes(tmp_path: Path, text: str) -> tuple[str, ...]:
    path = tmp_path / "maker.xml"
    path.write_text(text)
    return read_esi(path)[0].notes


@pytest.mark.parametrize("nth", range(9))
def test_the_type_of_an_object_comes_from_cia_402(tmp_path, nth):
    def written(kind: str) -> str:
        words = KINDS[kind] if kind else ("",)
        return words[nth % len(words)]

    drive = merged(tmp_path, drive_file(written))
    kinds = {e.index: e.kind for e in (*drive.output_entries, *drive.input_entries) if e.index}
    assert {0x607A, 0x60FF, 0x6064, 0x606C} == {i for i, k in kinds.items() if k == "int32"}
    assert {0x6071, 0x6077} == {i for i, k in kinds.items() if k == "int16"}
    assert {0x6060, 0x6061} == {i for i, k in kinds.items() if k == "int8"}
    assert {0x6040, 0x6041, 0x603F} == {i for i, k in kinds.items() if k == "uint16"}
    sent = Layout([(e.kind, e.bits) for e in drive.output_entries]).pack(
        (15, 9, 0, -50000, -1234, -7)
    )
    assert sent == struct.pack("<HbBiih", 15, 9, 0, -50000, -1234, -7)


@pytest.mark.parametrize(
    ("index", "bits", "words"),
    [
        (0x607A, 16, "entry 0x607A has 16 bits, CiA 402 has int32"),
        (0x6071, 32, "entry 0x6071 has 32 bits, CiA 402 has int16"),
    ],
)
def test_an_object_of_another_size_than_in_cia_402_is_refused(tmp_path, index, bits, words):
    text = drive_file(lambda _: "").replace(entry(index, 48 - bits, ""), entry(index, bits, ""))
    with pytest.raises(EsiError, match=words):
        notes(tmp_path, text)


def test_a_type_that_contradicts_its_length_is_refused(tmp_path):
    more = f"<TxPdo><Index>#x1A01</Index>{entry(0x2001, 16, 'DINT')}</TxPdo>"
    with pytest.raises(
        EsiError, match="maker.xml.*entry 0x2001 has 16 bits, its type DINT has 32"
    ):
        notes(tmp_path, drive_file(more=more))


def test_a_terminal_has_no_objects_of_cia_402(tmp_path):
    """Channel 5 of a terminal of eight channels has the index of the control word."""
    text = drive_file().replace("<SubIndex>0</SubIndex>", "<SubIndex>17</SubIndex>")
    text = text.replace(entry(0x607A, 32, "DINT").replace(">0</Sub", ">17</Sub"),
                        entry(0x607A, 16, "UINT").replace(">0</Sub", ">17</Sub"))  # fmt: skip
    path = tmp_path / "terminal.xml"
    path.write_text(text)
    (device,) = read_esi(path)
    kinds = {e.index: e.kind for p in device.outputs for e in p.entries if e.index}
    assert kinds[0x607A] == "uint16"


def test_a_channel_without_a_known_type_has_that_of_the_bus_file(tmp_path):
    bus = read_bus_file(BUS_FILES / "bench.yaml")
    old = next(s for s in bus.slaves if s.device == "analogue_input")
    places = [e for e in old.input_entries if e.channel]

    def terminal(kind: str, bits: int) -> str:
        rows = "".join(
            f"<Entry><Index>#x{e.index:04X}</Index><SubIndex>{e.subindex}</SubIndex>"
            f"<BitLen>{bits}</BitLen><DataType>{kind}</DataType></Entry>"
            for e in places
        )
        head, _, rest = drive_file(commands="").partition("<RxPdo")
        tail = rest[rest.index("<Mailbox>") :]
        return f'{head}<TxPdo Sm="3"><Index>#x1A00</Index>{rows}</TxPdo>{tail}'

    path = tmp_path / "terminal.xml"
    path.write_text(terminal("SOMETHING", places[0].bits))
    new = merge_device(bus, old.name, read_esi(path)[0]).slave(old.name)
    assert [e.kind for e in new.input_entries] == [e.kind for e in places]
    path.write_text(terminal("SOMETHING", 64))
    with pytest.raises(EsiError, match="has 64 bits and no type that is known"):
        merge_device(bus, old.name, read_esi(path)[0])


@pytest.mark.parametrize(
    ("text", "value"),
    [("08", 8), ("00000003", 3), ("#x1A00", 0x1A00), ("#X1a00", 0x1A00), ("0x1A", 26),
     (" 26 ", 26), ("+7", 7), ("0", 0), ("4294967295", 2**32 - 1)],
)  # fmt: skip
def test_numbers_of_a_maker(text, value):
    assert parse_number(text, "here") == value


@pytest.mark.parametrize(
    "text", [None, "", " ", "x", "-1", "1e3", "1_0", "#x", "0x", "#xG", "0b1", "0o7", "4294967296",
             "٣", "1.0", "NaN", "#b101"],
)  # fmt: skip
def test_what_is_no_number_is_refused_with_its_place(text):
    with pytest.raises(EsiError, match=r"^here: (BitLen|X) (is|has)|^here is") as caught:
        parse_number(text, "here")
    assert "\n" not in str(caught.value)


def test_of_alternative_pdos_the_first_is_assigned(tmp_path):
    own = entry(0x6040, 16, "UINT") + entry(0x60FF, 32, "DINT")
    more = f'<RxPdo Sm="2"><Index>#x1601</Index><Exclude>#x1600</Exclude>{own}</RxPdo>'
    text = drive_file(more=more)
    drive = merged(tmp_path, text)
    assert [(p.index, p.assigned) for p in drive.outputs] == [(0x1600, True), (0x1601, False)]
    (note,) = notes(tmp_path, text)
    assert "0x1601" in note and "0x1600" in note and "exclude" in note
    # the first may be the one that says it
    other = drive_file(more=more.replace("<Exclude>#x1600</Exclude>", "")).replace(
        "<Index>#x1600</Index>", "<Index>#x1600</Index><Exclude>#x1601</Exclude>"
    )
    assert [p.assigned for p in merged(tmp_path, other).outputs] == [True, False]


def test_pdos_that_share_objects_without_excluding_each_other_have_each_channel_once(tmp_path):
    more = f'<RxPdo Sm="2"><Index>#x1601</Index>{entry(0x6040, 16, "UINT")}</RxPdo>'
    drive = merged(tmp_path, drive_file(more=more))
    assert [e.channel for e in drive.output_entries].count("wheel.control_word") == 1


def test_a_file_without_a_vendor_is_refused_with_its_name(tmp_path):
    with pytest.raises(EsiError, match="maker.xml: Id of the Vendor is missing"):
        notes(tmp_path, drive_file(vendor=""))


def test_start_up_commands_are_kept_in_the_order_of_their_transitions(tmp_path):
    sub = "<SubIndex>1</SubIndex>"
    commands = (
        COMMAND.format("", "PS", sub, "0102030405060708090A")
        + COMMAND.format("", " IP ", sub, "25")
        + COMMAND.format("", "PS", sub, " 0a 0B\n0C ")
        + COMMAND.format("", "PS", sub, "26")
    )
    drive = merged(tmp_path, drive_file(commands=commands))
    values = [s for s in drive.sdos if s.index == 0x2005]
    assert [encode_value(s.kind, s.value) for s in values] == [
        b"\x25", bytes(range(1, 11)), b"\x0a\x0b\x0c", b"\x26"
    ]  # fmt: skip
    assert not notes(tmp_path, drive_file(commands=commands))


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (
            COMMAND.format("", "SO", "", "25"),
            "0x2005:0 = 0x25 is not written: its transition is SO",
        ),
        (COMMAND.format("", "PI", "", "25"), "its transition is PI"),
        (COMMAND.format(' CompleteAccess="1"', "PS", "", "0102"), "complete access"),
        (COMMAND.format("", "PS", "", ""), "it has no data"),
        (COMMAND.format("", "PS", "", "00").replace("2005", "1C12"), "follow from the PDOs"),
        (COMMAND.format("", "PS", "", "00").replace("2005", "1A00"), "follow from the PDOs"),
    ],
)
def test_a_start_up_command_that_is_not_written_is_named(tmp_path, command, words):
    (note,) = notes(tmp_path, drive_file(commands=command))
    assert words in note


@pytest.mark.parametrize("data", ["zz", "0", "0x25", "01 0"])
def test_data_that_are_not_hexadecimal_are_refused_with_file_and_object(tmp_path, data):
    with pytest.raises(EsiError, match=r"maker.xml.*InitCmd 0x2005: Data is '.*hexadecimal"):
        notes(tmp_path, drive_file(commands=COMMAND.format("", "PS", "", data)))


def test_octets_of_a_bus_file_need_quotes(tmp_path):
    drive = read_bus_file(BUS_FILES / "bench.yaml").slave("wheel_drive")
    raw = {"name": drive.name, "device": "drive", "vendor": 1, "product": 1, "revision": 1}
    for value, good in (("0102aF", True), (1234, False), ("0x12", False), ("123", False)):
        sdo = {"object": "0x2005:1", "type": "octets", "value": value}
        bus = {"format": "flatplank-bus/1", "name": "b", "slaves": [raw | {"sdos": [sdo]}]}
        if good:
            (read,) = parse_bus(bus).slaves[0].sdos
            assert encode_value(read.kind, read.value) == b"\x01\x02\xaf"
        else:
            with pytest.raises(BusFileError, match="hexadecimal digits in pairs, in quotes"):
                parse_bus(bus)


def test_objects_of_a_second_axis_have_the_same_types():
    assert cia402_type(0x687A, 0) == "int32" and cia402_type(0x607A, 1) == ""
    assert cia402_type(0x2071, 0) == cia402_type(0x1018, 0) == ""
    assert set(CIA402_TYPES.values()) <= set(TYPES)


def test_the_command_says_what_it_leaves_out_and_refuses_in_one_line(tmp_path, capsys):
    path, bus = tmp_path / "maker.xml", str(BUS_FILES / "bench.yaml")
    path.write_text(drive_file(commands=COMMAND.format("", "SO", "", "25")))
    words = [str(path), "--bus", bus, "--slave", "wheel_drive", "--rated-torque-nm", "5"]
    assert main(words) == 0
    said = capsys.readouterr()
    assert "esi: note: start-up command 0x2005:0" in said.err and "slaves:" in said.out
    for wrong in ([str(tmp_path / "none.xml")], [*words, "--type", "X"], [*words[:-2]],
                  [*words, "--out", str(tmp_path / "no" / "folder" / "b.yaml")]):  # fmt: skip
        assert main(wrong) == 2
        (line,) = capsys.readouterr().err.strip().splitlines()
        assert line.startswith("flatplank esi: ")
    with pytest.raises(SystemExit) as stopped:
        main([*words, "--product", "0b1"])
    assert stopped.value.code == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1


def test_a_document_type_is_refused_in_every_encoding(tmp_path):
    bomb = drive_file().replace("<EtherCATInfo>", "<!DOCTYPE a [<!ENTITY b 'c'>]><EtherCATInfo>")
    for code in ("utf-8", "utf-16"):
        path = tmp_path / "maker.xml"
        path.write_bytes(bomb.encode(code))
        with pytest.raises(EsiError, match="document type"):
            read_esi(path)


def test_damaged_files_are_refused_in_one_line_or_read_right():
    found = damaged_esi(Options(share=0.02, seed=20261128))
    assert found.many == 400
    assert not found.failures
