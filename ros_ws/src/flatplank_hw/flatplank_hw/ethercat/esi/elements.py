# SPDX-License-Identifier: Apache-2.0
"""Elements common to ESI and ENI files: PDOs and a device."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from xml.etree import ElementTree

from flatplank_hw.ethercat.busfile import Entry, Mailbox, Pdo, SdoValue, SyncManagers
from flatplank_hw.ethercat.esi.commands import is_mapping
from flatplank_hw.ethercat.esi.numbers import EsiError, cia402_type, parse_number, type_of
from flatplank_hw.ethercat.layout import TYPES

CONTROL_WORD, STATUS_WORD = (0x6040, 0), (0x6041, 0)


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
    notes: tuple[str, ...] = ()
    """what of the file is not used, one line each"""
    untyped: frozenset[tuple[int, int]] = frozenset()
    """objects (index, subindex) whose DataType is missing or not known"""


@dataclass(frozen=True)
class Pdos:
    """PDOs of one direction."""

    pdos: tuple[Pdo, ...]
    excluded: tuple[frozenset[int], ...]
    """per PDO: indices of those that must not be assigned beside it"""
    untyped: frozenset[tuple[int, int]]


def read_pdos(nodes: Sequence[ElementTree.Element], where: str) -> Pdos:
    """PDOs of a device in one direction; those with an `Sm` are assigned."""
    pdos, excluded, untyped = [], [], set()
    for node in nodes:
        index = parse_number(node.findtext("Index"), f"{where}: Index of a PDO", 0xFFFF)
        here = f"{where}: PDO 0x{index:04X}"
        if not is_mapping(index):
            raise EsiError(f"{here}: must be within 0x1600 .. 0x17FF or 0x1A00 .. 0x1BFF")
        entries = []
        for e in node.iterfind("Entry"):
            entry, said = _entry(e, here)
            entries.append(entry)
            if entry.index and not said:
                untyped.add((entry.index, entry.subindex))
        name = (node.findtext("Name") or "").strip()
        pdos.append(Pdo(index, tuple(entries), name, assigned="Sm" in node.attrib))
        others = (
            parse_number(x.text, f"{here}: Exclude", 0xFFFF) for x in node.iterfind("Exclude")
        )
        excluded.append(frozenset(others))
    return Pdos(tuple(pdos), tuple(excluded), frozenset(untyped))


def without_alternatives(found: Pdos) -> tuple[Pdos, tuple[str, ...]]:
    """Of PDOs that exclude each other only the first stays assigned; one note per other one."""
    taken: dict[int, frozenset[int]] = {}
    pdos, notes = [], []
    for pdo, excluded in zip(found.pdos, found.excluded, strict=True):
        rivals = [i for i, theirs in taken.items() if i in excluded or pdo.index in theirs]
        if pdo.assigned and rivals:
            notes.append(
                f"PDO 0x{pdo.index:04X} is not assigned: it and PDO 0x{rivals[0]:04X}, which "
                "comes first, exclude each other"
            )
            pdo = replace(pdo, assigned=False)
        elif pdo.assigned:
            taken[pdo.index] = excluded
        pdos.append(pdo)
    return replace(found, pdos=tuple(pdos)), tuple(notes)


def with_cia402_types(outputs: Pdos, inputs: Pdos, where: str) -> tuple[Pdos, Pdos]:
    """PDOs of a drive with the types of CiA 402; those of other devices stay as they are."""
    places = {(e.index, e.subindex) for p in (*outputs.pdos, *inputs.pdos) for e in p.entries}
    if places.isdisjoint((CONTROL_WORD, STATUS_WORD)):
        return outputs, inputs
    return _by_profile(outputs, where), _by_profile(inputs, where)


def _by_profile(found: Pdos, where: str) -> Pdos:
    def typed(pdo: Pdo, entry: Entry) -> Entry:
        kind = cia402_type(entry.index, entry.subindex)
        if kind and TYPES[kind][0] != entry.bits:
            raise EsiError(
                f"{where}: PDO 0x{pdo.index:04X}: entry 0x{entry.index:04X} has {entry.bits} "
                f"bits, CiA 402 has {kind}: ask the maker for a corrected file"
            )
        return replace(entry, kind=kind) if kind else entry

    pdos = [replace(p, entries=tuple(typed(p, e) for e in p.entries)) for p in found.pdos]
    untyped = frozenset(place for place in found.untyped if not cia402_type(*place))
    return replace(found, pdos=tuple(pdos), untyped=untyped)


def _entry(node: ElementTree.Element, where: str) -> tuple[Entry, bool]:
    """An entry, and whether its type is known."""
    index = parse_number(node.findtext("Index"), f"{where}: Index of an entry", 0xFFFF)
    here = f"{where}: entry 0x{index:04X}"
    bits = parse_number(node.findtext("BitLen"), f"{here}: BitLen", 64)
    if not bits:
        raise EsiError(f"{here}: BitLen is 0, must be within 1 .. 64")
    if index == 0:
        return Entry(0, 0, "", bits, name="padding"), True
    kind, said = type_of((node.findtext("DataType") or "").strip(), bits, here)
    subindex = parse_number(node.findtext("SubIndex") or "0", f"{here}: SubIndex", 0xFF)
    return Entry(index, subindex, kind, bits, (node.findtext("Name") or "").strip()), said
