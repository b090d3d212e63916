# SPDX-License-Identifier: Apache-2.0
"""Damaged device descriptions of makers (ESI): each is refused in one line, or read as another
reader of XML reads it.
"""

from __future__ import annotations

import random
import re
from collections.abc import Callable
from functools import cache
from pathlib import Path
from xml.dom import minidom

from flatplank_data.yaml_text import parse_yaml
from flatplank_hw.ethercat.busfile import BusFile
from flatplank_hw.ethercat.esi import EsiDevice, merge_device, read_esi
from flatplank_hw.ethercat.reader import parse_bus, read_bus_file
from flatplank_hw.ethercat.writer import write_bus
from flatplank_hw.share import config_file

OBJECTS = {
    "RxPdo": ((0x6040, 16, "UINT"), (0x6060, 8, "SINT"), (0, 8, ""), (0x607A, 32, "DINT"),
              (0x60FF, 32, "DINT"), (0x6071, 16, "INT")),
    "TxPdo": ((0x6041, 16, "UINT"), (0x6061, 8, "SINT"), (0, 8, ""), (0x6064, 32, "DINT"),
              (0x606C, 32, "DINT"), (0x6077, 16, "INT"), (0x603F, 16, "UINT")),
}  # fmt: skip
"""direction -> entries of a drive: object, bits, type"""
INIT_COMMANDS = (
    "<InitCmd><Transition>PS</Transition><Index>#x6098</Index><SubIndex>0</SubIndex>"
    "<Data>25</Data></InitCmd>"
)


def entry(index: int, bits: int | str, kind: str) -> str:
    """An entry of a PDO."""
    if not index:
        return f"<Entry><Index>0</Index><BitLen>{bits}</BitLen></Entry>"
    data_type = f"<DataType>{kind}</DataType>" if kind else ""
    return (
        f"<Entry><Index>#x{index:04X}</Index><SubIndex>0</SubIndex><BitLen>{bits}</BitLen>"
        f"<Name>n</Name>{data_type}</Entry>"
    )


def drive_file(
    types: Callable[[str], str] = lambda kind: kind,
    commands: str = INIT_COMMANDS,
    more: str = "",
    vendor: str = "<Vendor><Id>#xB9</Id></Vendor>",
    revision: str = "#x1",
) -> str:
    """ESI file of a CiA 402 drive; `types` changes the data types, `more` adds PDOs."""
    pdos = "".join(
        f'<{tag} Sm="{sm}"><Index>#x{index:04X}</Index>'
        + "".join(entry(i, bits, types(kind)) for i, bits, kind in OBJECTS[tag])
        + f"</{tag}>"
        for tag, sm, index in (("RxPdo", 2, 0x1600), ("TxPdo", 3, 0x1A00))
    )
    return (
        f'<?xml version="1.0"?><EtherCATInfo>{vendor}<Descriptions><Devices><Device>'
        f'<Type ProductCode="#x1001" RevisionNo="{revision}">DRV</Type><Name>Drive</Name>'
        '<Sm DefaultSize="256" StartAddress="#x1800" ControlByte="#x26">MBoxOut</Sm>'
        '<Sm DefaultSize="256" StartAddress="#x1900" ControlByte="#x22">MBoxIn</Sm>'
        '<Sm StartAddress="#x1A00" ControlByte="#x64">Outputs</Sm>'
        '<Sm StartAddress="#x1C00" ControlByte="#x20">Inputs</Sm>'
        f'{pdos}{more}<Mailbox><CoE SdoInfo="1" PdoAssign="1">{commands}</CoE></Mailbox>'
        "</Device></Devices></Descriptions></EtherCATInfo>"
    )


ODD = (
    "",
    "x",
    "08",
    "-1",
    "1e3",
    "99999999999",
    "#xZZ",
    " 5 ",
    "NaN",
    "0x",
    "#x",
    "1_0",
    "٣",
    "1.5",
)
TYPES = ("INT32", "INTEGER32", "UDINT", "REAL", "STRING(8)", "", "int", "BOOL", "DINT ", "LINT")
LENGTHS = ("1", "8", "16", "32", "64", "128")
DATA = ("0", "zz", "01 02 03", "", "0x1")
_NUMBER = re.compile(r"(?<=>)#?x?[0-9A-F]+(?=<)")
_ELEMENT = re.compile(r"<(\w+)(?: [^<>]*)?>[^<>]*</\1>")


def _at(draw: random.Random, text: str) -> tuple[int, int]:
    a = draw.randrange(len(text))
    return a, min(a + draw.randrange(1, 60), len(text))


def _byte(draw: random.Random, text: str) -> str:
    a, _ = _at(draw, text)
    return text[:a] + chr(draw.randrange(1, 256)) + text[a + 1 :]


def _cut(draw: random.Random, text: str) -> str:
    a, b = _at(draw, text)
    return text[:a] + text[b:]


def _twice(draw: random.Random, text: str) -> str:
    a, b = _at(draw, text)
    return text[:b] + text[a:]


def _end(draw: random.Random, text: str) -> str:
    return text[: draw.randrange(len(text))]


def _one(pattern: re.Pattern[str], word: Callable[[random.Random], str]):
    def change(draw: random.Random, text: str) -> str:
        found = list(pattern.finditer(text))
        if not found:
            return text
        a, b = draw.choice(found).span()
        return text[:a] + word(draw) + text[b:]

    return change


WAYS: tuple[Callable[[random.Random, str], str], ...] = (
    _byte, _cut, _twice, _end,
    _one(_NUMBER, lambda draw: draw.choice(ODD)),
    _one(_ELEMENT, lambda _: ""),
    _one(re.compile(r"(?<=<DataType>)[^<]*"), lambda draw: draw.choice(TYPES)),
    _one(re.compile(r"(?<=<BitLen>)[^<]*"), lambda draw: draw.choice(LENGTHS)),
    _one(re.compile(r"(?<=<Data>)[^<]*"), lambda draw: draw.choice(DATA)),
    _one(re.compile(r"<EtherCATInfo>"), lambda _: "<!DOCTYPE a [<!ENTITY b 'c'>]><EtherCATInfo>"),
)  # fmt: skip
"""ways of damage"""
CODES = ("utf-8", "utf-8", "utf-8", "utf-16", "latin-1")


def damaged(draw: random.Random) -> bytes:
    """A file with one to three kinds of damage."""
    text = drive_file()
    for _ in range(draw.randrange(1, 4)):
        text = draw.choice(WAYS)(draw, text) or "<"
    return text.encode(draw.choice(CODES), errors="replace")


def failure(data: bytes, path: Path) -> str:
    """Empty when a file is refused in one line that names it, or read right."""
    path.write_bytes(data)
    try:
        devices = read_esi(path)
        for device in devices:
            _merged(device)
    except ValueError as error:
        text = str(error)
        named = path.name in text or "slave 'wheel_drive'" in text or "DRV" in text
        return "" if named and "\n" not in text else f"refused without the file's name: {text}"
    except Exception as error:  # whatever else it is, it is the failure that is looked for
        return f"{type(error).__name__}: {error}"
    ours, theirs = [_plain(d) for d in devices], _other_reader(data)
    return "" if ours == theirs else f"read as {ours}, another reader has {theirs}"


@cache
def _bus() -> BusFile:
    path = config_file("flatplank_hw", "bus/bench.yaml")
    assert path is not None, "the package has this file"
    return read_bus_file(path)


def _merged(device: EsiDevice) -> None:
    """Put a device into the bus file; its signed channels must be signed."""
    merged = merge_device(_bus(), "wheel_drive", device, 5.0)
    drive = parse_bus(parse_yaml(write_bus(merged))).slave("wheel_drive")
    kinds = {e.channel: e.kind for e in (*drive.output_entries, *drive.input_entries)}
    signed = ("velocity", "position", "target_velocity", "target_position")
    wrong = {c: k for c, k in kinds.items() if c.rpartition(".")[2] in signed and k != "int32"}
    if wrong:
        raise AssertionError(f"channels that are not int32: {wrong}")


def _plain(device: EsiDevice) -> list[tuple[int, list[tuple[int, int, int]]]]:
    return [
        (pdo.index, [(e.index, e.subindex, e.bits) for e in pdo.entries])
        for pdo in (*device.outputs, *device.inputs)
    ]


def _children(node: minidom.Node, tag: str) -> list[minidom.Element]:
    return [c for c in node.childNodes if isinstance(c, minidom.Element) and c.tagName == tag]


def _text(node: minidom.Element, tag: str) -> str:
    found = _children(node, tag)
    texts = found[0].childNodes if found else []
    return "".join(c.data for c in texts if isinstance(c, minidom.Text))


def _number(node: minidom.Element, tag: str) -> int:
    word = _text(node, tag).strip().lower() or "0"
    return int(word[2:], 16) if word[:2] in ("#x", "0x") else int(word, 10)


def _entries(pdo: minidom.Element) -> list[tuple[int, int, int]]:
    out = []
    for e in _children(pdo, "Entry"):
        index, bits = _number(e, "Index"), _number(e, "BitLen")
        out.append((index, _number(e, "SubIndex") if index else 0, bits))
    return out


def _other_reader(data: bytes) -> list[list[tuple[int, list[tuple[int, int, int]]]]]:
    """The PDOs of all devices by the document model of the standard library."""
    return [
        [
            (_number(pdo, "Index"), _entries(pdo))
            for tag in OBJECTS
            for pdo in _children(device, tag)
        ]
        for device in minidom.parseString(data).getElementsByTagName("Device")
        if getattr(device.parentNode, "tagName", "") == "Devices"
    ]
