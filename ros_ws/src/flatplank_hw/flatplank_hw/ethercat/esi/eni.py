# SPDX-License-Identifier: Apache-2.0
"""Reads an ENI file (ETG.2100), the bus configuration that a configuration tool writes for a
master."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from xml.etree import ElementTree

from flatplank_hw.ethercat.busfile import Mailbox, SyncManagers
from flatplank_hw.ethercat.esi.commands import ASSIGNMENTS, is_mapping, start_commands
from flatplank_hw.ethercat.esi.elements import EsiDevice, Pdos, read_pdos, with_cia402_types
from flatplank_hw.ethercat.esi.numbers import EsiError, parse_number

_MANAGERS = [f"Sm{n}" for n in range(16)]


def config_devices(root: ElementTree.Element, path: str) -> list[EsiDevice]:
    """One device per slave, in the order of the wire; its type name is the slave's name."""
    return [_device(node, path) for node in root.iterfind("Config/Slave")]


def _device(node: ElementTree.Element, path: str) -> EsiDevice:
    name = (node.findtext("Info/Name") or "").strip()
    where = f"{path}: slave '{name or '?'}'"
    if not name:
        raise EsiError(f"{where}: no <Info><Name>")
    data = node.find("ProcessData")
    data = ElementTree.Element("ProcessData") if data is None else data
    commands = list(node.iterfind("Mailbox/CoE/InitCmds/InitCmd"))
    written = {
        parse_number(c.findtext("Index"), f"{where}: Index of an InitCmd") for c in commands
    }
    sdos, notes = start_commands(commands, where)
    outputs, inputs = with_cia402_types(
        _pdos(data, "RxPdo", where), _pdos(data, "TxPdo", where), where
    )
    return EsiDevice(
        type_name=name,
        name=name,
        vendor=parse_number(node.findtext("Info/VendorId"), f"{where}: VendorId"),
        product=parse_number(node.findtext("Info/ProductCode"), f"{where}: ProductCode"),
        revision=parse_number(node.findtext("Info/RevisionNo") or "0", f"{where}: RevisionNo"),
        mailbox=_mailbox(node, where),
        sync_managers=_sync_managers(data, where),
        outputs=outputs.pdos,
        inputs=inputs.pdos,
        fixed_assignment=written.isdisjoint(ASSIGNMENTS),
        dc=node.find("DC") is not None,
        sdos=sdos,
        write_mapping=any(is_mapping(index) for index in written),
        notes=notes,
        untyped=outputs.untyped | inputs.untyped,
    )


def _mailbox(node: ElementTree.Element, where: str) -> Mailbox | None:
    if node.find("Mailbox/CoE") is None:
        return None
    places = ("Send/Start", "Send/Length", "Recv/Start", "Recv/Length")
    out_start, out_size, in_start, in_size = (
        parse_number(node.findtext(f"Mailbox/{place}"), f"{where}: {place}", 0xFFFF)
        for place in places
    )
    return Mailbox(out_start, out_size, in_start, in_size)


def _managers(data: ElementTree.Element) -> Iterator[ElementTree.Element]:
    for name in _MANAGERS:
        yield from data.iterfind(name)


def _sync_managers(data: ElementTree.Element, where: str) -> SyncManagers | None:
    found = {
        (m.findtext("Type") or "").strip(): (
            parse_number(m.findtext("StartAddress"), f"{where}: StartAddress", 0xFFFF),
            parse_number(m.findtext("ControlByte") or "0", f"{where}: ControlByte", 0xFF),
        )
        for m in _managers(data)
    }
    if found.keys().isdisjoint(("Outputs", "Inputs")):
        return None
    return SyncManagers(*found.get("Outputs", (0, 0)), *found.get("Inputs", (0, 0)))


def _pdos(data: ElementTree.Element, kind: str, where: str) -> Pdos:
    """PDOs; assigned: those that a sync manager lists, or without lists those with an `Sm`."""
    listed = {
        parse_number(p.text, f"{where}: Pdo of a sync manager", 0xFFFF)
        for m in _managers(data)
        for p in m.iterfind("Pdo")
    }
    found = read_pdos(data.findall(kind), where)
    if not listed:
        return found
    return replace(found, pdos=tuple(replace(p, assigned=p.index in listed) for p in found.pdos))
