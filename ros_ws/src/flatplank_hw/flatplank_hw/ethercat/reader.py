# SPDX-License-Identifier: Apache-2.0
"""Bus file in YAML to dataclasses, strict: what nobody would read is an error with a hint."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flatplank_data.params import nearest
from flatplank_data.yaml_text import load_yaml
from flatplank_hw.ethercat import channels
from flatplank_hw.ethercat.busfile import (
    FORMAT,
    BusFile,
    Entry,
    Mailbox,
    Pdo,
    SdoValue,
    Slave,
    SyncManagers,
)
from flatplank_hw.ethercat.layout import TYPES
from flatplank_hw.ethercat.strict import (
    BusFileError,
    check_keys,
    integer,
    mapping,
    number,
    sequence,
)

DEVICES = (
    "coupler",
    "drive",
    "analogue_input",
    "encoder",
    "digital_input",
    "digital_output",
    "generic",
)
_BUS_KEYS = ("format", "name", "rate_hz", "watchdog_ms", "command_timeout_ms", "slaves")
_SLAVE_KEYS = [
    "name",
    "device",
    "vendor",
    "product",
    "revision",
    "check_revision",
    "serial",
    "placeholder",
    "axis",
    "dc",
    "mailbox",
    "sync_managers",
    "outputs",
    "inputs",
    "write_assignment",
    "write_mapping",
    "sdos",
    "objects",
]
_ENTRY_KEYS = [
    "object",
    "type",
    "pad",
    "name",
    "channel",
    "full_scale_volts",
    "full_scale_counts",
    "unit_nm",
]


def read_bus_file(path: str | Path) -> BusFile:
    """Read and check a bus file."""
    path = Path(path)
    try:
        text = path.read_bytes()
    except OSError as error:
        raise BusFileError(
            f"bus file {path}: {error.strerror}; give the path of a bus file"
        ) from None
    return parse_bus(load_yaml(text, f"bus file {path}"), str(path))


def parse_bus(raw: Any, path: str = "bus file") -> BusFile:
    """Check a parsed bus file; `path` names it in errors."""
    top = mapping(raw, path)
    check_keys(top, _BUS_KEYS, path, required=("format", "name", "slaves"))
    if top["format"] != FORMAT:
        raise BusFileError(f"{path}: format is '{top['format']}'; this version reads '{FORMAT}'")
    slaves = tuple(
        _slave(mapping(item, f"{path}: slaves[{i}]"), f"{path}: slaves[{i}]")
        for i, item in enumerate(sequence(top["slaves"], f"{path}: slaves"))
    )
    if not slaves:
        raise BusFileError(f"{path}: no slaves; list them in the order of the wire")
    bus = BusFile(
        name=str(top["name"]),
        slaves=slaves,
        rate_hz=integer(top.get("rate_hz", 250), f"{path}: rate_hz", 50, 2000),
        watchdog_ms=integer(top.get("watchdog_ms", 40), f"{path}: watchdog_ms", 5, 1000),
        command_timeout_ms=integer(
            top.get("command_timeout_ms", 44), f"{path}: command_timeout_ms", 5, 1000
        ),
        path=path,
    )
    _check_channels(bus, path)
    return bus


def _slave(raw: Mapping[str, Any], where: str) -> Slave:
    required = ("name", "device", "vendor", "product", "revision")
    check_keys(raw, _SLAVE_KEYS, where, required=required)
    name = str(raw["name"])
    where = f"{where} ({name})"
    if raw["device"] not in DEVICES:
        raise BusFileError(
            f"{where}: unknown device '{raw['device']}'{nearest(raw['device'], DEVICES)}"
        )
    return Slave(
        name=name,
        device=raw["device"],
        **{key: integer(raw[key], f"{where}: {key}") for key in required[2:]},
        check_revision=bool(raw.get("check_revision", False)),
        serial=integer(raw.get("serial", 0), f"{where}: serial"),
        placeholder=str(raw.get("placeholder", "")),
        axis=str(raw.get("axis", "")),
        dc=bool(raw.get("dc", False)),
        mailbox=_mailbox(raw.get("mailbox"), f"{where}: mailbox"),
        sync_managers=_sync_managers(raw.get("sync_managers"), f"{where}: sync_managers"),
        outputs=_pdos(raw.get("outputs"), f"{where}: outputs", channels.OUTPUTS),
        inputs=_pdos(raw.get("inputs"), f"{where}: inputs", channels.INPUTS),
        write_assignment=bool(raw.get("write_assignment", False)),
        write_mapping=bool(raw.get("write_mapping", False)),
        sdos=_sdos(raw.get("sdos"), f"{where}: sdos"),
        objects=_sdos(raw.get("objects"), f"{where}: objects"),
    )


def _mailbox(raw: Any, where: str) -> Mailbox | None:
    if raw is None or raw is False:
        return None
    if raw is True:
        return Mailbox()
    raw = mapping(raw, where)
    check_keys(raw, Mailbox.__dataclass_fields__, where)
    flags = ("complete_access", "sdo_info")
    values = {
        k: bool(v) if k in flags else integer(v, f"{where}: {k}", 0, 0xFFFF)
        for k, v in raw.items()
    }
    return Mailbox(**values)


def _sync_managers(raw: Any, where: str) -> SyncManagers | None:
    if raw is None:
        return None
    raw = mapping(raw, where)
    fields = SyncManagers.__dataclass_fields__
    check_keys(raw, fields, where, required=fields)
    return SyncManagers(**{k: integer(v, f"{where}: {k}", 0, 0xFFFF) for k, v in raw.items()})


def _pdos(raw: Any, where: str, known: frozenset[str]) -> tuple[Pdo, ...]:
    pdos = []
    for i, item in enumerate(sequence(raw, where)):
        here = f"{where}[{i}]"
        item = mapping(item, here)
        check_keys(item, ("pdo", "name", "assigned", "entries"), here, required=("pdo", "entries"))
        entries = tuple(
            _entry(mapping(e, f"{here}.entries[{k}]"), f"{here}.entries[{k}]", known)
            for k, e in enumerate(sequence(item["entries"], f"{here}.entries"))
        )
        index = integer(item["pdo"], f"{here}: pdo", 0x1600, 0x1BFF)
        assigned = bool(item.get("assigned", True))
        pdos.append(Pdo(index, entries, str(item.get("name", "")), assigned))
    return tuple(pdos)


def _entry(raw: Mapping[str, Any], where: str, known: frozenset[str]) -> Entry:
    check_keys(raw, _ENTRY_KEYS, where)
    channel = str(raw.get("channel", ""))
    if channel and channel not in known:
        raise BusFileError(f"{where}: unknown channel '{channel}'{nearest(channel, known)}")
    if "pad" in raw:
        bits = integer(raw["pad"], f"{where}: pad", 1, 64)
        return Entry(0, 0, "", bits, name="padding", channel=channel)
    check_keys(raw, _ENTRY_KEYS, where, required=("object", "type"))
    index, subindex = parse_object(raw["object"], where)
    kind = str(raw["type"])
    if kind not in TYPES:
        raise BusFileError(f"{where}: unknown type '{kind}'{nearest(kind, TYPES)}")
    entry = Entry(
        index,
        subindex,
        kind,
        TYPES[kind][0],
        name=str(raw.get("name", "")),
        channel=channel,
        full_scale_volts=number(raw.get("full_scale_volts", 0), f"{where}: full_scale_volts"),
        full_scale_counts=integer(
            raw.get("full_scale_counts", 0), f"{where}: full_scale_counts", 0, 2**31
        ),
        unit_nm=number(raw.get("unit_nm", 0), f"{where}: unit_nm"),
    )
    _check_facts(entry, where)
    return entry


def _check_facts(entry: Entry, where: str) -> None:
    """A channel with a unit needs the raw facts that give it."""
    if entry.channel in channels.VOLTS and not (
        entry.full_scale_volts and entry.full_scale_counts
    ):
        raise BusFileError(
            f"{where}: channel '{entry.channel}' needs full_scale_volts and full_scale_counts"
        )
    if entry.channel.rpartition(".")[2] in channels.TORQUES and not entry.unit_nm:
        raise BusFileError(
            f"{where}: channel '{entry.channel}' needs unit_nm, the torque of one count"
        )


def parse_object(text: Any, where: str) -> tuple[int, int]:
    """'0x6040:1' or 0x6040 to (index, subindex)."""
    head, _, tail = str(text).partition(":")
    return (
        integer(head, f"{where}: object", 0x1000, 0xFFFF),
        integer(tail or 0, f"{where}: object", 0, 255),
    )


def _sdos(raw: Any, where: str) -> tuple[SdoValue, ...]:
    values = []
    for i, item in enumerate(sequence(raw, where)):
        here = f"{where}[{i}]"
        item = mapping(item, here)
        check_keys(
            item, ("object", "type", "value", "name"), here, required=("object", "type", "value")
        )
        kind = str(item["type"])
        if kind not in TYPES and kind != "string":
            raise BusFileError(f"{here}: unknown type '{kind}'{nearest(kind, [*TYPES, 'string'])}")
        value = (
            str(item["value"])
            if kind == "string"
            else integer(item["value"], f"{here}: value", -(2**63), 2**64 - 1)
        )
        values.append(
            SdoValue(*parse_object(item["object"], here), kind, value, str(item.get("name", "")))
        )
    return tuple(values)


def _check_channels(bus: BusFile, path: str) -> None:
    names: set[str] = set()
    seen: set[str] = set()
    for slave in bus.slaves:
        if slave.name in names:
            raise BusFileError(f"{path}: two slaves are named '{slave.name}'")
        names.add(slave.name)
        for entry in (*slave.input_entries, *slave.output_entries):
            if entry.channel and entry.channel in seen:
                raise BusFileError(f"{path}: channel '{entry.channel}' is given twice")
            seen.add(entry.channel)
