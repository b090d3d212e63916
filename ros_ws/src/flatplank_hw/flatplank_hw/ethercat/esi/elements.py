# SPDX-License-Identifier: Apache-2.0
"""Elements common to ESI and ENI files: numbers, PDOs, start-up commands, and a device."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from xml.etree import ElementTree

from flatplank_hw.ethercat.busfile import Entry, Mailbox, Pdo, SdoValue, SyncManagers

_TYPES = {
    "BOOL": "bool",
    "BIT": "bool",
    "BIT1": "bool",
    "SINT": "int8",
    "INT": "int16",
    "DINT": "int32",
    "LINT": "int64",
    "USINT": "uint8",
    "UINT": "uint16",
    "UDINT": "uint32",
    "ULINT": "uint64",
    "BYTE": "uint8",
    "WORD": "uint16",
    "DWORD": "uint32",
    "BITARR8": "uint8",
    "BITARR16": "uint16",
    "BITARR32": "uint32",
    "INT24": "int24",
    "UINT24": "uint24",
}
ASSIGNMENTS = (0x1C12, 0x1C13)
"""objects with the PDO assignment"""
_BY_BITS = {1: "bool", 8: "uint8", 16: "uint16", 24: "uint24", 32: "uint32", 64: "uint64"}


class EsiError(ValueError):
    """A device description that cannot be used, described in one line."""


@dataclass(frozen=True)
class EsiDevice:
    """One device of the file."""

    type_name: str
    name: str
    vendor: int
    product: int
    revision: int
    mailbox: Mailbox | None
    sync_managers: SyncManagers | None
    outputs: tuple[Pdo, ...]
    inputs: tuple[Pdo, ...]
    fixed_assignment: bool
    dc: bool
    sdos: tuple[SdoValue, ...]
    write_mapping: bool = False


def parse_number(text: str | None, where: str) -> int:
    """Parse '#x1A00', '0x1A00' or a decimal number."""
    try:
        return int((text or "").strip().replace("#x", "0x"), 0)
    except ValueError:
        raise EsiError(f"{where}: '{text}' is not a number") from None


def read_pdo(node: ElementTree.Element, where: str) -> Pdo:
    return Pdo(
        parse_number(node.findtext("Index"), where),
        tuple(_entry(e, where) for e in node.iterfind("Entry")),
        (node.findtext("Name") or "").strip(),
        assigned="Sm" in node.attrib,
    )


def _entry(node: ElementTree.Element, where: str) -> Entry:
    index = parse_number(node.findtext("Index"), where)
    bits = parse_number(node.findtext("BitLen"), where)
    if index == 0:
        return Entry(0, 0, "", bits, name="padding")
    raw = (node.findtext("DataType") or "").strip()
    kind = _TYPES.get(raw) or (f"bit{raw[3:]}" if raw.startswith("BIT") else "")
    kind = kind or _BY_BITS.get(bits, f"bit{bits}" if bits < 8 else "")
    if not kind:
        raise EsiError(f"{where}: entry 0x{index:04X} has type '{raw}' of {bits} bits, not known")
    name = (node.findtext("Name") or "").strip()
    return Entry(index, parse_number(node.findtext("SubIndex") or "0", where), kind, bits, name)


def is_mapping(index: int) -> bool:
    """True for a PDO mapping object."""
    return 0x1600 <= index < 0x1800 or 0x1A00 <= index < 0x1C00


def start_commands(commands: Iterable[ElementTree.Element], where: str) -> tuple[SdoValue, ...]:
    """Start-up commands of the transition from PREOP to SAFEOP."""
    values = []
    for command in commands:
        if "PS" not in [t.text for t in command.iterfind("Transition")]:
            continue
        data = bytes.fromhex((command.findtext("Data") or "").strip())
        kind = _BY_BITS.get(len(data) * 8)
        index = parse_number(command.findtext("Index"), where)
        if kind is None or index in ASSIGNMENTS or is_mapping(index):
            continue
        subindex = parse_number(command.findtext("SubIndex") or "0", where)
        name = (command.findtext("Comment") or "").strip()
        values.append(SdoValue(index, subindex, kind, int.from_bytes(data, "little"), name))
    return tuple(values)
