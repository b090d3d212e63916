# SPDX-License-Identifier: Apache-2.0
"""Reads an ENI file (ETG.2100), the bus configuration that a configuration tool writes for a
master."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from xml.etree import ElementTree

from flatplank_hw.ethercat.busfile import Mailbox, Pdo, SyncManagers
from flatplank_hw.ethercat.esi.elements import (
    ASSIGNMENTS,
    EsiDevice,
    EsiError,
    is_mapping,
    parse_number,
    read_pdo,
    start_commands,
)

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
    written = {parse_number(c.findtext("Index"), where) for c in commands}
    return EsiDevice(
        type_name=name,
        name=name,
        vendor=parse_number(node.findtext("Info/VendorId"), where),
        product=parse_number(node.findtext("Info/ProductCode"), where),
        revision=parse_number(node.findtext("Info/RevisionNo") or "0", where),
        mailbox=_mailbox(node, where),
        sync_managers=_sync_managers(data, where),
        outputs=tuple(_pdos(data, "RxPdo", where)),
        inputs=tuple(_pdos(data, "TxPdo", where)),
        fixed_assignment=written.isdisjoint(ASSIGNMENTS),
        dc=node.find("DC") is not None,
        sdos=start_commands(commands, where),
        write_mapping=any(is_mapping(index) for index in written),
    )


def _mailbox(node: ElementTree.Element, where: str) -> Mailbox | None:
    if node.find("Mailbox/CoE") is None:
        return None
    places = ("Send/Start", "Send/Length", "Recv/Start", "Recv/Length")
    out_start, out_size, in_start, in_size = (
        parse_number(node.findtext(f"Mailbox/{place}"), where) for place in places
    )
    return Mailbox(out_start, out_size, in_start, in_size)


def _managers(data: ElementTree.Element) -> Iterator[ElementTree.Element]:
    for name in _MANAGERS:
        yield from data.iterfind(name)


def _sync_managers(data: ElementTree.Element, where: str) -> SyncManagers | None:
    found = {
        (m.findtext("Type") or "").strip(): (
            parse_number(m.findtext("StartAddress"), where),
            parse_number(m.findtext("ControlByte") or "0", where),
        )
        for m in _managers(data)
    }
    if found.keys().isdisjoint(("Outputs", "Inputs")):
        return None
    return SyncManagers(*found.get("Outputs", (0, 0)), *found.get("Inputs", (0, 0)))


def _pdos(data: ElementTree.Element, kind: str, where: str) -> Iterator[Pdo]:
    """PDOs; assigned: those that a sync manager lists, or without lists those with an `Sm`."""
    listed = {parse_number(p.text, where) for m in _managers(data) for p in m.iterfind("Pdo")}
    for node in data.iterfind(kind):
        found = read_pdo(node, where)
        yield replace(found, assigned=found.index in listed) if listed else found
