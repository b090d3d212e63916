# SPDX-License-Identifier: Apache-2.0
"""Bus files: what is in ours, what is refused and with which words, the round trip, and ESI
import."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml
from ethercat_rig import BUS_FILES

from flatplank_hw.bus.image import AXES
from flatplank_hw.ethercat import channels
from flatplank_hw.ethercat.esi import (
    EsiError,
    find_device,
    merge_device,
    read_esi,
    slave_from_device,
)
from flatplank_hw.ethercat.esi.__main__ import main as esi_main
from flatplank_hw.ethercat.layout import TYPES, Layout, limits
from flatplank_hw.ethercat.reader import parse_bus, read_bus_file
from flatplank_hw.ethercat.strict import BusFileError
from flatplank_hw.ethercat.writer import write_bus

DATA = Path(__file__).parent / "data"
FILES = sorted(BUS_FILES.glob("*.yaml"))


def bench() -> dict[str, Any]:
    """Our bench file as plain data, to be spoilt."""
    return yaml.safe_load((BUS_FILES / "bench.yaml").read_text())


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_round_trip(path: Path) -> None:
    bus = read_bus_file(path)
    assert parse_bus(yaml.safe_load(write_bus(bus))) == bus


def test_the_bench_has_every_channel() -> None:
    bus = read_bus_file(BUS_FILES / "bench_five_axes.yaml")
    inputs = {e.channel for s in bus.slaves for e in s.input_entries} - {""}
    outputs = {e.channel for s in bus.slaves for e in s.output_entries} - {""}
    assert inputs == channels.INPUTS and outputs == channels.OUTPUTS
    assert {s.axis for s in bus.slaves} - {""} == set(AXES)


def test_placeholders_are_marked() -> None:
    """Nothing in our files claims to be a maker's identity that is not."""
    for path in FILES:
        for slave in read_bus_file(path).slaves:
            assert slave.placeholder or slave.device == "coupler", f"{path.name}: {slave.name}"


def spoil(raw: dict[str, Any], where: list[Any], value: Any) -> None:
    for key in where[:-1]:
        raw = raw[key]
    raw[where[-1]] = value


ROWS = ["slaves", 1, "outputs", 0, "entries"]
ENTRY = [*ROWS, 0]
VOLTS = ["slaves", 2, "inputs", 0, "entries", 0, "full_scale_volts"]


@pytest.mark.parametrize(
    ("where", "value", "words"),
    [
        (["format"], "flatplank-bus/9", "this version reads 'flatplank-bus/1'"),
        (["rate"], 250, "unknown key 'rate'.*rate_hz"),
        (["rate_hz"], 5000, "5000 is outside 50..2000"),
        (["rate_hz"], "fast", "'fast' is not a whole number"),
        (["slaves"], [], "no slaves"),
        (["slaves"], {"a": 1}, "expected a list"),
        (["slaves", 0], "coupler", "expected a mapping"),
        (["slaves", 0, "device"], "drve", "unknown device 'drve'.*drive"),
        (["slaves", 1, "vendor"], True, "True is not a whole number"),
        (["slaves", 1, "vendor"], -1, "-1 is outside"),
        (["slaves", 1, "name"], "coupler", "two slaves are named 'coupler'"),
        ([*ENTRY, "channel"], "wheel.controlword", "unknown channel.*wheel.control_word"),
        ([*ENTRY, "channel"], "wheel.status_word", "unknown channel 'wheel.status_word'"),
        ([*ENTRY, "type"], "uint17", "unknown type 'uint17'.*uint1"),
        ([*ENTRY, "object"], "0x60zz:0", "'0x60zz' is not a whole number"),
        ([*ENTRY, "object"], "0x10:0", "outside"),
        ([*ROWS, 1, "channel"], "wheel.control_word", "given twice"),
        ([*ROWS, 5, "unit_nm"], 0, "needs unit_nm"),
        (VOLTS, 0, "needs full_scale_volts"),
        (VOLTS, float("nan"), "not a number"),
        (["slaves", 1, "outputs", 0, "pdo"], 0x1200, "outside"),
        (["slaves", 1, "mailbox"], {"out_sise": 5}, "unknown key 'out_sise'.*out_size"),
        (["slaves", 1, "sdos", 0, "type"], "floatish", "unknown type"),
    ],
)  # fmt: skip
def test_refusals(where: list[Any], value: Any, words: str) -> None:
    raw = bench()
    spoil(raw, where, value)
    with pytest.raises(BusFileError, match=words) as caught:
        parse_bus(raw, "my.yaml")
    assert str(caught.value).startswith("my.yaml") and "\n" not in str(caught.value)


@pytest.mark.parametrize("text", ["a: [", "- 1\n", "\0", "just words"])
def test_files_that_are_no_bus_files(tmp_path: Path, text: str) -> None:
    path = tmp_path / "bad.yaml"
    path.write_text(text)
    with pytest.raises(BusFileError, match=r"bad\.yaml") as caught:
        read_bus_file(path)
    assert "\n" not in str(caught.value)


# --- layouts ------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", TYPES)
def test_extremes_of_every_type(kind: str) -> None:
    bits = TYPES[kind][0]
    odd = Layout([("", 3), (kind, bits), ("", 5)])
    even = Layout([(kind, bits)])
    for value in (*limits(kind), 0):
        assert odd.unpack(odd.pack((5, value, 9)))[1] == value
        assert even.unpack(even.pack((value,))) == (value,)


def test_shifting_and_struct_agree() -> None:
    kinds = ["uint16", "int8", "int32", "uint8", "int64"]
    values = (65535, -128, -5, 200, -(2**63))
    whole = Layout([(k, TYPES[k][0]) for k in kinds])
    pieces = Layout([*((k, TYPES[k][0]) for k in kinds), ("bool", 1)])
    assert pieces.pack((*values, 1))[:-1] == whole.pack(values)
    assert pieces.unpack(whole.pack(values) + b"\0") == (*values, 0)


# --- ESI ----------------------------------------------------------------------------------


def test_esi_device() -> None:
    device = find_device(read_esi(DATA / "servo.xml"), "SERVO-A", revision=0x10000)
    assert (device.vendor, device.product, device.revision) == (0xB9, 0x1001, 0x10000)
    assert device.mailbox.out_start == 0x1800 and device.mailbox.in_size == 256
    assert not device.mailbox.complete_access and device.dc and not device.fixed_assignment
    assert device.sync_managers.outputs_start == 0x1A00
    assert [p.assigned for p in device.outputs] == [True, False]
    assert sum(p.bits for p in device.inputs) == 128
    assert [(s.index, s.value) for s in device.sdos] == [(0x6098, 0x25)]


def test_esi_choice() -> None:
    devices = read_esi(DATA / "servo.xml")
    assert find_device(devices, "SERVO-A").revision == 0x20000
    assert find_device(devices, product=0x2002).type_name == "DI-4"
    with pytest.raises(EsiError, match="SERVO-A"):
        find_device(devices, "SERV0-A")
    with pytest.raises(EsiError, match="several devices fit"):
        find_device(devices)


def test_esi_replaces_a_placeholder() -> None:
    """Identity and PDOs are the maker's, the channels ours, the rest of the bus untouched."""
    bus = read_bus_file(BUS_FILES / "bench.yaml")
    device = find_device(read_esi(DATA / "servo.xml"), "SERVO-A", revision=0x10000)
    merged = merge_device(bus, "wheel_drive", device, rated_torque_nm=5.0)
    drive = merged.slave("wheel_drive")
    assert (drive.product, drive.revision, drive.placeholder) == (0x1001, 0x10000, "")
    by_channel = {e.channel: e for e in (*drive.output_entries, *drive.input_entries)}
    assert by_channel["wheel.target_torque"].unit_nm == 0.005
    assert by_channel["echo"].bits == 8 and by_channel["wheel.error_code"].index == 0x603F
    assert {s.index for s in drive.sdos} == {0x6098, 0x605A, 0x6085}
    assert merged.slaves[2:] == bus.slaves[2:]
    assert parse_bus(yaml.safe_load(write_bus(merged))) == merged


def test_esi_never_loses_a_channel_silently() -> None:
    bus = read_bus_file(BUS_FILES / "bench.yaml")
    devices = read_esi(DATA / "servo.xml")
    old = find_device(devices, "SERVO-A", revision=0x10000)
    with pytest.raises(EsiError, match="wheel.target_torque.*give the rated torque"):
        merge_device(bus, "wheel_drive", old)
    with pytest.raises(EsiError, match="no place for wheel.error_code"):
        merge_device(bus, "wheel_drive", find_device(devices, "SERVO-A"), 5.0)
    with pytest.raises(EsiError, match="wheel_drive"):
        merge_device(bus, "wheel_driv", old, 5.0)


def test_esi_digital_terminal() -> None:
    device = find_device(read_esi(DATA / "servo.xml"), "DI-4")
    slave = slave_from_device(device, "inputs", "digital_input")
    assert slave.input_bits == 4 and slave.mailbox is None
    assert [e.kind for e in slave.input_entries] == ["bool", "bit3"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<a", "not XML"),
        ("<Other/>", "expected <EtherCATInfo>"),
        ("<!DOCTYPE a [<!ENTITY b 'c'>]><EtherCATInfo/>", "refused"),
        ("<EtherCATInfo><Vendor><Id>x</Id></Vendor></EtherCATInfo>", "'x' is not a number"),
        (
            "<EtherCATInfo><Vendor><Id>1</Id></Vendor><Descriptions><Devices><Device>"
            "<Type>T</Type></Device></Devices></Descriptions></EtherCATInfo>",
            "no <Type ProductCode",
        ),
    ],
)
def test_esi_refusals(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "bad.xml"
    path.write_text(text)
    with pytest.raises(EsiError, match=words) as caught:
        read_esi(path)
    assert "bad.xml" in str(caught.value) and "\n" not in str(caught.value)


def test_esi_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source, bus = str(DATA / "servo.xml"), str(BUS_FILES / "bench.yaml")
    assert esi_main([source]) == 0
    assert "SERVO-A: product 0x00001001" in capsys.readouterr().out
    out = tmp_path / "new.yaml"
    words = [source, "--type", "SERVO-A", "--revision", "0x10000", "--bus", bus]
    words += ["--slave", "wheel_drive", "--rated-torque-nm", "5", "--out", str(out)]
    assert esi_main(words) == 0
    assert read_bus_file(out).slave("wheel_drive").product == 0x1001
    assert esi_main([source, "--type", "NONE", "--bus", bus, "--slave", "wheel_drive"]) == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1
