# SPDX-License-Identifier: Apache-2.0
"""Device descriptions in further spellings: the types of CiA 402, or a refusal with the reason."""

from __future__ import annotations

from pathlib import Path

import pytest
from ethercat_rig import BUS_FILES

from flatplank_hw.ethercat.busfile import Slave
from flatplank_hw.ethercat.esi import EsiDevice, EsiError, merge_device, read_esi
from flatplank_hw.ethercat.reader import read_bus_file
from flatplank_validation.trust.esi_damage import drive_file, entry


def merged(tmp_path: Path, text: str | bytes) -> tuple[Slave, EsiDevice]:
    path = tmp_path / "maker.xml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    (device,) = read_esi(path)
    bus = merge_device(read_bus_file(BUS_FILES / "bench.yaml"), "wheel_drive", device, 5.0)
    return bus.slave("wheel_drive"), device


def as_type(text: str) -> str:
    return drive_file(types=lambda kind: text if kind == "DINT" else kind)


def command(transitions: str, data: str, index: str = "#x2005") -> str:
    body = "".join(f"<Transition>{t}</Transition>" for t in transitions.split())
    body += f"<Index>{index}</Index><SubIndex>01</SubIndex><Data>{data}</Data>"
    return f"<InitCmd>{body}</InitCmd>"


def alternative(index: int, *excluded: int, manager: str = ' Sm="2"') -> str:
    rivals = "".join(f"<Exclude>#x{other:04X}</Exclude>" for other in excluded)
    entries = entry(0x6040, 16, "UINT") + entry(0x60FF, 32, "DINT")
    return f"<RxPdo{manager}><Index>#x{index:04X}</Index>{rivals}{entries}</RxPdo>"


WHOLE = drive_file()
READ = {
    **{f"type {t}": as_type(t) for t in ("I32", "int32_t", "SIGNED32", "LONG", "STRING(4)")},
    **{f"revision {r}": drive_file(revision=r) for r in ("00000003", "#X3", "0x03", " 3 ")},
    "vendor 0185": drive_file(vendor="<Vendor><Id>0185</Id></Vendor>"),
    "length 032": WHOLE.replace("<BitLen>32", "<BitLen>032"),
    "length #x20": WHOLE.replace("<BitLen>32", "<BitLen>#x20"),
    "byte order mark": WHOLE.encode("utf-8-sig"),
    "UTF-16": WHOLE.replace('"1.0"', '"1.0" encoding="utf-16"').encode("utf-16"),
    "three alternatives": drive_file(
        more=alternative(0x1601, 0x1600, 0x1602) + alternative(0x1602, 0x1600, 0x1601)
    ),
    "an alternative without a manager": drive_file(more=alternative(0x1601, 0x1600, manager="")),
}
REFUSED = {
    "a type of another length": (as_type("ULINT"), "its type ULINT has 64 bits"),
    "a negative revision": (drive_file(revision="-1"), "RevisionNo is '-1', not a number"),
    "a revision of 33 bits": (drive_file(revision="#x100000000"), "must be within 0 .."),
    "no vendor": (drive_file(vendor=""), "Id of the Vendor is missing"),
    "length 0": (WHOLE.replace("<BitLen>32", "<BitLen>0"), "BitLen is 0"),
    "a PDO with the index of an object": (drive_file(more=alternative(0x6040)), "must be within"),
    "half a byte of data": (drive_file(commands=command("PS", "012")), "hexadecimal digits in"),
    "no hexadecimal data": (drive_file(commands=command("PS", "#x01")), "hexadecimal digits in"),
}
WRITTEN = {
    "IP and PS": (command("IP PS", "0102"), ("uint16", 0x0201)),
    "blanks and lines": (command("PS", " 01 02\n03 04 05 "), ("octets", "0102030405")),
    "small letters": (command("IP", "abcdef"), ("uint24", 0xEFCDAB)),
    "forty bytes": (command("PS", "AB" * 40), ("octets", "AB" * 40)),
    "a decimal index": (command("PS", "01", "8197"), ("uint8", 1)),
}
TOLD = {
    "PI": command("PI", "01"), "SO": command("SO", "01"), "no transition": command("", "01"),
    "no data": command("PS", ""),
}  # fmt: skip


@pytest.mark.parametrize("case", READ)
def test_further_spellings_give_the_signed_types(case, tmp_path):
    slave, device = merged(tmp_path, READ[case])
    kinds = {e.channel: e.kind for e in (*slave.output_entries, *slave.input_entries)}
    for name in ("position", "velocity", "target_position", "target_velocity"):
        assert kinds[f"wheel.{name}"] == "int32"
    assert kinds["wheel.torque"] == kinds["wheel.target_torque"] == "int16"
    assert [p.index for p in slave.outputs if p.assigned] == [0x1600]
    assert device.vendor == 0xB9 and device.revision in (1, 3)


@pytest.mark.parametrize("case", REFUSED)
def test_contradictions_are_refused_with_their_reason(case, tmp_path):
    text, words = REFUSED[case]
    with pytest.raises(EsiError, match="maker.xml") as caught:
        merged(tmp_path, text)
    assert words in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize("case", WRITTEN)
def test_start_up_commands_in_further_spellings_are_written(case, tmp_path):
    text, (kind, value) = WRITTEN[case]
    slave, device = merged(tmp_path, drive_file(commands=text))
    (found,) = (s for s in slave.sdos if s.index == 0x2005)
    assert (found.subindex, found.kind) == (1, kind)
    assert found.value == value and not device.notes


@pytest.mark.parametrize("case", TOLD)
def test_start_up_commands_that_are_not_written_are_told(case, tmp_path):
    slave, device = merged(tmp_path, drive_file(commands=TOLD[case]))
    assert not [s for s in slave.sdos if s.index == 0x2005]
    (note,) = device.notes
    assert note.startswith("start-up command 0x2005:1 = ")
