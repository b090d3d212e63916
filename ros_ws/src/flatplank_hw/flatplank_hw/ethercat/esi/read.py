# SPDX-License-Identifier: Apache-2.0
"""An ESI file (XML) to its devices: identity, sync managers, PDOs, start-up commands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from flatplank_hw.ethercat.busfile import Entry, Mailbox, Pdo, SdoValue, SyncManagers
from flatplank_hw.ethercat.strict import nearest

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
_BY_BITS = {1: "bool", 8: "uint8", 16: "uint16", 24: "uint24", 32: "uint32", 64: "uint64"}


class EsiError(ValueError):
    """A device description that cannot be used: one line."""


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


def read_esi(path: str | Path) -> list[EsiDevice]:
    """All devices of a file, in its order."""
    path = Path(path)
    try:
        text = path.read_bytes()
    except OSError as error:
        raise EsiError(f"ESI file {path}: {error.strerror}") from None
    if b"<!DOCTYPE" in text or b"<!ENTITY" in text:
        raise EsiError(f"ESI file {path}: has a document type, which no ESI file needs; refused")
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise EsiError(f"ESI file {path}: not XML ({error})") from None
    if root.tag != "EtherCATInfo":
        raise EsiError(f"ESI file {path}: starts with <{root.tag}>, expected <EtherCATInfo>")
    vendor = _number(root.findtext("Vendor/Id"), f"{path}: Vendor/Id")
    return [_device(node, vendor, str(path)) for node in root.iterfind(".//Devices/Device")]


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
        raise EsiError(
            f"no such device{nearest(type_name, names)}; in the file: {', '.join(names)}"
        )
    if len({d.product for d in found}) > 1:
        names = ", ".join(f"{d.type_name} (0x{d.product:08X})" for d in found)
        raise EsiError(f"several devices fit, give type or product: {names}")
    return max(found, key=lambda d: d.revision)


def _device(node: ElementTree.Element, vendor: int, path: str) -> EsiDevice:
    kind = node.find("Type")
    where = f"{path}: device '{(kind.text or '').strip() if kind is not None else '?'}'"
    if kind is None or "ProductCode" not in kind.attrib:
        raise EsiError(f"{where}: no <Type ProductCode=...>")
    type_name = (kind.text or "").strip()
    coe = node.find("Mailbox/CoE")
    return EsiDevice(
        type_name=type_name,
        name=(node.findtext("Name") or type_name).strip(),
        vendor=vendor,
        product=_number(kind.get("ProductCode"), where),
        revision=_number(kind.get("RevisionNo", "0"), where),
        mailbox=_mailbox(node, coe, where),
        sync_managers=_sync_managers(node, where),
        outputs=tuple(_pdo(p, where) for p in node.iterfind("RxPdo")),
        inputs=tuple(_pdo(p, where) for p in node.iterfind("TxPdo")),
        fixed_assignment=coe is None or not _flag(coe, "PdoAssign"),
        dc=node.find("Dc") is not None,
        sdos=_sdos(coe, where),
    )


def _mailbox(
    node: ElementTree.Element, coe: ElementTree.Element | None, where: str
) -> Mailbox | None:
    managers = {(sm.text or "").strip(): sm for sm in node.iterfind("Sm")}
    if coe is None or "MBoxOut" not in managers or "MBoxIn" not in managers:
        return None
    out, back = managers["MBoxOut"], managers["MBoxIn"]
    return Mailbox(
        _number(out.get("StartAddress"), where),
        _number(out.get("DefaultSize"), where),
        _number(back.get("StartAddress"), where),
        _number(back.get("DefaultSize"), where),
        complete_access=_flag(coe, "CompleteAccess"),
        sdo_info=_flag(coe, "SdoInfo"),
    )


def _sync_managers(node: ElementTree.Element, where: str) -> SyncManagers | None:
    values = {"Outputs": (0, 0), "Inputs": (0, 0)}
    for sm in node.iterfind("Sm"):
        name = (sm.text or "").strip()
        if name in values:
            start = _number(sm.get("StartAddress"), where)
            values[name] = (start, _number(sm.get("ControlByte", "0"), where))
    if values == {"Outputs": (0, 0), "Inputs": (0, 0)}:
        return None
    return SyncManagers(*values["Outputs"], *values["Inputs"])


def _pdo(node: ElementTree.Element, where: str) -> Pdo:
    return Pdo(
        _number(node.findtext("Index"), where),
        tuple(_entry(e, where) for e in node.iterfind("Entry")),
        (node.findtext("Name") or "").strip(),
        assigned="Sm" in node.attrib,
    )


def _entry(node: ElementTree.Element, where: str) -> Entry:
    index = _number(node.findtext("Index"), where)
    bits = _number(node.findtext("BitLen"), where)
    if index == 0:
        return Entry(0, 0, "", bits, name="padding")
    raw = (node.findtext("DataType") or "").strip()
    kind = _TYPES.get(raw) or (f"bit{raw[3:]}" if raw.startswith("BIT") else "")
    kind = kind or _BY_BITS.get(bits, f"bit{bits}" if bits < 8 else "")
    if not kind:
        raise EsiError(f"{where}: entry 0x{index:04X} has type '{raw}' of {bits} bits, not known")
    name = (node.findtext("Name") or "").strip()
    return Entry(index, _number(node.findtext("SubIndex") or "0", where), kind, bits, name)


def _sdos(coe: ElementTree.Element | None, where: str) -> tuple[SdoValue, ...]:
    """Start-up commands of the step from PREOP to SAFEOP."""
    values = []
    for command in coe.iterfind("InitCmd") if coe is not None else ():
        if "PS" not in [t.text for t in command.iterfind("Transition")]:
            continue
        data = bytes.fromhex((command.findtext("Data") or "").strip())
        kind = _BY_BITS.get(len(data) * 8)
        index = _number(command.findtext("Index"), where)
        if kind is None or index in (0x1C12, 0x1C13):
            continue
        subindex = _number(command.findtext("SubIndex") or "0", where)
        name = (command.findtext("Comment") or "").strip()
        values.append(SdoValue(index, subindex, kind, int.from_bytes(data, "little"), name))
    return tuple(values)


def _flag(node: ElementTree.Element, name: str) -> bool:
    return node.get(name, "0").lower() in ("1", "true")


def _number(text: str | None, where: str) -> int:
    """'#x1A00', '0x1A00' or decimal."""
    try:
        return int((text or "").strip().replace("#x", "0x"), 0)
    except ValueError:
        raise EsiError(f"{where}: '{text}' is not a number") from None
