# SPDX-License-Identifier: Apache-2.0
"""Reads devices of an ESI or ENI file (XML): identity, sync managers, PDOs, start-up commands."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree
from xml.parsers import expat

from flatplank_data.names import nearest_hint
from flatplank_hw.ethercat.busfile import Mailbox, SyncManagers
from flatplank_hw.ethercat.esi.commands import start_commands
from flatplank_hw.ethercat.esi.elements import (
    EsiDevice,
    read_pdos,
    with_cia402_types,
    without_alternatives,
)
from flatplank_hw.ethercat.esi.eni import config_devices
from flatplank_hw.ethercat.esi.numbers import EsiError, parse_number


def read_esi(path: str | Path) -> list[EsiDevice]:
    """All devices of a file, in file order."""
    path = Path(path)
    try:
        text = path.read_bytes()
    except OSError as error:
        raise EsiError(f"ESI file {path}: {error.strerror}") from None
    root = _parsed(text, f"ESI file {path}")
    reader = _READERS.get(root.tag)
    if reader is None:
        raise EsiError(f"ESI file {path}: starts with <{root.tag}>, expected {_EXPECTED}")
    return reader(root, str(path))


def _parsed(text: bytes, where: str) -> ElementTree.Element:
    """Root of the document. A document type is refused before its entities can be expanded."""

    def refuse(*_: object) -> None:
        raise EsiError(f"{where}: has a document type, which no ESI file needs; refused")

    try:
        first = expat.ParserCreate()
        first.StartDoctypeDeclHandler = refuse
        first.Parse(text, True)
        return ElementTree.fromstring(text)
    except EsiError:
        raise
    except (expat.ExpatError, ElementTree.ParseError, LookupError, ValueError) as error:
        raise EsiError(f"{where}: not XML ({error})") from None


def _info_devices(root: ElementTree.Element, path: str) -> list[EsiDevice]:
    vendor = parse_number(root.findtext("Vendor/Id"), f"{path}: Id of the Vendor")
    return [_device(node, vendor, path) for node in root.iterfind(".//Devices/Device")]


_READERS = {"EtherCATInfo": _info_devices, "EtherCATConfig": config_devices}
_EXPECTED = " or ".join(f"<{tag}>" for tag in _READERS)


def find_device(
    devices: Sequence[EsiDevice],
    type_name: str = "",
    product: int | None = None,
    revision: int | None = None,
) -> EsiDevice:
    """One device by type name or product code; the newest revision when none is given."""
    found = [
        d
        for d in devices
        if (not type_name or type_name in (d.type_name, d.name))
        and (product is None or d.product == product)
        and (revision is None or d.revision == revision)
    ]
    if not found:
        names = sorted({d.type_name for d in devices})
        raise EsiError(f"no such device{nearest_hint(type_name, names)}")
    if len({d.product for d in found}) > 1:
        fitting = ", ".join(f"{d.type_name} (0x{d.product:08X})" for d in found)
        raise EsiError(f"several devices fit, give type or product: {fitting}")
    return max(found, key=lambda d: d.revision)


def _device(node: ElementTree.Element, vendor: int, path: str) -> EsiDevice:
    kind = node.find("Type")
    where = f"{path}: device '{(kind.text or '').strip() if kind is not None else '?'}'"
    if kind is None or "ProductCode" not in kind.attrib:
        raise EsiError(f"{where}: no <Type ProductCode=...>")
    type_name = (kind.text or "").strip()
    coe = node.find("Mailbox/CoE")
    outputs, left_out = without_alternatives(read_pdos(node.findall("RxPdo"), where))
    inputs, left_in = without_alternatives(read_pdos(node.findall("TxPdo"), where))
    outputs, inputs = with_cia402_types(outputs, inputs, where)
    sdos, unwritten = start_commands(coe.iterfind("InitCmd") if coe is not None else (), where)
    return EsiDevice(
        type_name=type_name,
        name=(node.findtext("Name") or type_name).strip(),
        vendor=vendor,
        product=parse_number(kind.get("ProductCode"), f"{where}: ProductCode"),
        revision=parse_number(kind.get("RevisionNo", "0"), f"{where}: RevisionNo"),
        mailbox=_mailbox(node, coe, where),
        sync_managers=_sync_managers(node, where),
        outputs=outputs.pdos,
        inputs=inputs.pdos,
        fixed_assignment=coe is None or not _flag(coe, "PdoAssign"),
        dc=node.find("Dc") is not None,
        sdos=sdos,
        notes=(*left_out, *left_in, *unwritten),
        untyped=outputs.untyped | inputs.untyped,
    )


def _mailbox(
    node: ElementTree.Element, coe: ElementTree.Element | None, where: str
) -> Mailbox | None:
    managers = {(sm.text or "").strip(): sm for sm in node.iterfind("Sm")}
    if coe is None or "MBoxOut" not in managers or "MBoxIn" not in managers:
        return None
    out_start, out_size, in_start, in_size = (
        parse_number(managers[sm].get(name), f"{where}: {name} of {sm}", 0xFFFF)
        for sm in ("MBoxOut", "MBoxIn")
        for name in ("StartAddress", "DefaultSize")
    )
    return Mailbox(
        out_start,
        out_size,
        in_start,
        in_size,
        complete_access=_flag(coe, "CompleteAccess"),
        sdo_info=_flag(coe, "SdoInfo"),
    )


def _sync_managers(node: ElementTree.Element, where: str) -> SyncManagers | None:
    values = {"Outputs": (0, 0), "Inputs": (0, 0)}
    for sm in node.iterfind("Sm"):
        name = (sm.text or "").strip()
        if name in values:
            start = parse_number(sm.get("StartAddress"), f"{where}: StartAddress", 0xFFFF)
            control = parse_number(sm.get("ControlByte", "0"), f"{where}: ControlByte", 0xFF)
            values[name] = (start, control)
    if values == {"Outputs": (0, 0), "Inputs": (0, 0)}:
        return None
    return SyncManagers(*values["Outputs"], *values["Inputs"])


def _flag(node: ElementTree.Element, name: str) -> bool:
    return node.get(name, "0").lower() in ("1", "true")
