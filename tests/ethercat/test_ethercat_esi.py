# SPDX-License-Identifier: Apache-2.0
"""Makers' ESI files and tools' ENI files into the bus file."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from ethercat_rig import BUS_FILES

from flatplank_hw.ethercat.esi import (
    EsiError,
    find_device,
    merge_device,
    read_esi,
    slave_from_device,
)
from flatplank_hw.ethercat.esi.__main__ import main as esi_main
from flatplank_hw.ethercat.reader import parse_bus, read_bus_file
from flatplank_hw.ethercat.writer import write_bus

DATA = Path(__file__).parent / "data"


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
        (
            "<EtherCATInfo><Vendor><Id>x</Id></Vendor></EtherCATInfo>",
            "Id of the Vendor is 'x', not a number",
        ),
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
    assert "0x6099:0 = 0x1 is not written: its transition is SO" in capsys.readouterr().err
    assert esi_main([source, "--type", "NONE", "--bus", bus, "--slave", "wheel_drive"]) == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1


def test_eni_slave_is_the_device_of_the_esi_file() -> None:
    """The same servo drive, once by its maker and once in a configured line."""
    line = read_esi(DATA / "line.xml")
    assert [d.type_name for d in line] == ["Coupler", "Drive 1"]
    assert line[0].mailbox is None and line[0].sync_managers is None
    drive = find_device(line, "Drive 1")
    esi = find_device(read_esi(DATA / "servo.xml"), "SERVO-A", revision=0x10000)
    assert drive.outputs[0] == esi.outputs[0] and drive.inputs == esi.inputs
    for name in ("vendor", "product", "revision", "sync_managers", "fixed_assignment", "sdos"):
        assert getattr(drive, name) == getattr(esi, name), name
    assert drive.write_mapping and not esi.write_mapping
    assert [p.assigned for p in drive.outputs] == [True, False]


def test_eni_replaces_a_placeholder() -> None:
    bus = read_bus_file(BUS_FILES / "bench.yaml")
    merged = merge_device(
        bus, "wheel_drive", find_device(read_esi(DATA / "line.xml"), "Drive 1"), 5
    )
    drive = merged.slave("wheel_drive")
    assert (drive.product, drive.placeholder, drive.write_mapping) == (0x1001, "", True)
    assert parse_bus(yaml.safe_load(write_bus(merged))) == merged


@pytest.mark.parametrize(
    ("info", "words"),
    [
        ("<ProductCode>1</ProductCode>", r"slave '\?': no <Info><Name>"),
        ("<Name>D</Name><VendorId>2</VendorId>", "slave 'D': ProductCode is missing"),
    ],
)
def test_eni_refusals(tmp_path: Path, info: str, words: str) -> None:
    path = tmp_path / "bad.xml"
    slave = f"<Slave><Info>{info}</Info></Slave>"
    path.write_text(f"<EtherCATConfig><Config>{slave}</Config></EtherCATConfig>")
    with pytest.raises(EsiError, match=words) as caught:
        read_esi(path)
    assert "bad.xml" in str(caught.value) and "\n" not in str(caught.value)
