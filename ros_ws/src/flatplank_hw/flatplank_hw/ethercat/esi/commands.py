# SPDX-License-Identifier: Apache-2.0
"""Start-up commands of CoE (`InitCmd`): kept as start-up SDOs of the slave, or named."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from xml.etree import ElementTree

from flatplank_hw.ethercat.busfile import SdoValue
from flatplank_hw.ethercat.esi.numbers import EsiError, parse_number

ASSIGNMENTS = (0x1C12, 0x1C13)
"""objects with the PDO assignment"""
_BEFORE_SAFEOP = ("IP", "PS")
"""transitions after which, or in which, the master writes start-up SDOs: the slave is in PREOP"""
_UNSIGNED = {1: "uint8", 2: "uint16", 3: "uint24", 4: "uint32", 8: "uint64"}
"""number of bytes -> type of the value in the bus file; others are octets"""


def is_mapping(index: int) -> bool:
    """True for a PDO mapping object."""
    return 0x1600 <= index < 0x1800 or 0x1A00 <= index < 0x1C00


def start_commands(
    commands: Iterable[ElementTree.Element], where: str
) -> tuple[tuple[SdoValue, ...], tuple[str, ...]]:
    """Start-up SDOs in the order in which they are written, and a note on each command that is
    not among them."""
    values: dict[str, list[SdoValue]] = {name: [] for name in _BEFORE_SAFEOP}
    notes = []
    for command in commands:
        transitions = [(t.text or "").strip() for t in command.iterfind("Transition")]
        value = _value(command, where)
        when = [name for name in _BEFORE_SAFEOP if name in transitions]
        reason = _reason(command, value, transitions, when)
        if reason:
            notes.append(f"start-up command {_shown(value)} is not written: {reason}")
        else:
            values[when[0]].append(value)
    return tuple(v for name in _BEFORE_SAFEOP for v in values[name]), tuple(notes)


def _value(command: ElementTree.Element, where: str) -> SdoValue:
    index = parse_number(command.findtext("Index"), f"{where}: Index of an InitCmd", 0xFFFF)
    here = f"{where}: InitCmd 0x{index:04X}"
    subindex = parse_number(command.findtext("SubIndex") or "0", f"{here}: SubIndex", 0xFF)
    text = "".join((command.findtext("Data") or "").split())
    try:
        data = bytes.fromhex(text)
    except ValueError:
        raise EsiError(
            f"{here}: Data is '{text[:40]}', must be hexadecimal digits in pairs"
        ) from None
    name = " ".join((command.findtext("Comment") or "").split())
    kind = _UNSIGNED.get(len(data))
    if kind is None:
        return SdoValue(index, subindex, "octets", data.hex().upper(), name)
    return SdoValue(index, subindex, kind, int.from_bytes(data, "little"), name)


def _reason(
    command: ElementTree.Element, value: SdoValue, transitions: Sequence[str], when: Sequence[str]
) -> str:
    """Why a command cannot be a start-up SDO; empty when it can."""
    if not when:
        return f"its transition is {', '.join(transitions) or 'missing'}, not IP or PS"
    if value.index in ASSIGNMENTS or is_mapping(value.index):
        return "assignment and mapping follow from the PDOs of the bus file"
    if command.get("CompleteAccess", "0").strip().lower() in ("1", "true"):
        return "it wants complete access; write its entries one by one in `sdos`"
    return "" if value.value != "" else "it has no data"


def _shown(value: SdoValue) -> str:
    data = f"{value.value:#x}" if isinstance(value.value, int) else value.value or "-"
    name = f", {value.name}" if value.name else ""
    return f"0x{value.index:04X}:{value.subindex} = {data}{name}"
