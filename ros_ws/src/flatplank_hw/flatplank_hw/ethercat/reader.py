# SPDX-License-Identifier: Apache-2.0
"""Reads a bus file in YAML to dataclasses; an unknown key is an error with a hint."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from flatplank_data.errors import FlatplankError
from flatplank_data.names import nearest_hint
from flatplank_data.yaml_text import load_yaml
from flatplank_hw.ethercat import busfile
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
from flatplank_hw.ethercat.layout import OCTETS, TYPES

DEVICES = (
    "coupler", "drive", "analogue_input", "encoder", "digital_input", "digital_output", "generic",
)  # fmt: skip
_FACTS = ("full_scale_volts", "full_scale_counts", "unit_nm")


class BusFileError(FlatplankError):
    """A bus file that cannot be used: one line saying what, where and what to do."""


def check_mapping(
    value: Any, where: str, known: Iterable[str], required: Iterable[str] = ()
) -> Mapping[str, Any]:
    """Check that a value is a mapping with known keys only and all required ones; returns it."""
    if not isinstance(value, Mapping):
        raise BusFileError(f"{where}: expected a mapping, found {type(value).__name__}")
    for key in value:
        if key not in known:
            raise BusFileError(f"{where}: unknown key '{key}'{nearest_hint(key, known)}")
    for key in required:
        if key not in value:
            raise BusFileError(f"{where}: key '{key}' is missing")
    return value


def check_list(value: Any, where: str) -> list[tuple[str, Any]]:
    """Items of a list (None counts as empty), each with its location for errors."""
    if not isinstance(value, list | None):
        raise BusFileError(f"{where}: expected a list, found {type(value).__name__}")
    return [(f"{where}[{i}]", item) for i, item in enumerate(value or ())]


def check_integer(value: Any, where: str, low: int = 0, high: int = 0xFFFFFFFF) -> int:
    """Return an integer (decimal or 0x...); BusFileError outside `low`..`high`."""
    if isinstance(value, str):
        try:
            value = int(value, 0)
        except ValueError:
            raise BusFileError(f"{where}: '{value}' is not a whole number") from None
    if isinstance(value, bool) or not isinstance(value, int):
        raise BusFileError(f"{where}: {value!r} is not a whole number")
    if not low <= value <= high:
        raise BusFileError(f"{where}: {value} is outside {low}..{high}")
    return value


def _check_wide(value: Any, where: str) -> int:
    return check_integer(value, where, -(2**63), 2**64 - 1)


def check_octets(value: Any, where: str) -> str:
    """Return hexadecimal digits in pairs, in quotes in the file."""
    try:
        return bytes.fromhex(value).hex().upper()
    except (TypeError, ValueError):
        raise BusFileError(
            f"{where}: {value!r} must be hexadecimal digits in pairs, in quotes"
        ) from None


def check_number(value: Any, where: str) -> float:
    """Return a finite number; BusFileError for anything else."""
    if isinstance(value, bool) or not isinstance(value, int | float) or value - value != 0:
        raise BusFileError(f"{where}: {value!r} is not a number")
    return float(value)


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
    keys = ("format", "name", "rate_hz", "watchdog_ms", "command_timeout_ms", "slaves")
    top = check_mapping(raw, path, keys, required=("format", "name", "slaves"))
    if top["format"] != FORMAT:
        raise BusFileError(f"{path}: format is '{top['format']}'; this version reads '{FORMAT}'")
    slaves = tuple(
        _slave(item, where) for where, item in check_list(top["slaves"], f"{path}: slaves")
    )
    if not slaves:
        raise BusFileError(f"{path}: no slaves; list them in the order of the wire")
    ranges = {"rate_hz": (50, 2000), "watchdog_ms": (5, 1000), "command_timeout_ms": (5, 1000)}
    numbers = {k: check_integer(top[k], f"{path}: {k}", *r) for k, r in ranges.items() if k in top}
    bus = BusFile(name=str(top["name"]), slaves=slaves, path=path, **numbers)
    _check_channels(bus, path)
    return bus


def _simple(
    cls: type, raw: Mapping[str, Any], where: str, most: int = 0xFFFFFFFF
) -> dict[str, Any]:
    """Fields of a dataclass from a mapping, if they are flags, texts or numbers; `most`: largest
    allowed integer."""
    readers: dict[Any, Callable[[Any, str], Any]] = {
        "bool": lambda value, _: bool(value),
        "str": lambda value, _: str(value),
        "int": lambda value, at: check_integer(value, at, 0, most),
        "float": check_number,
    }
    return {
        f.name: readers[f.type](raw[f.name], f"{where}: {f.name}")
        for f in fields(cls)
        if f.name in raw and f.type in readers
    }


def _slave(raw: Any, where: str) -> Slave:
    required = ("name", "device", "vendor", "product", "revision")
    raw = check_mapping(raw, where, Slave.__dataclass_fields__, required)
    where = f"{where} ({raw['name']})"
    if raw["device"] not in DEVICES:
        raise BusFileError(
            f"{where}: unknown device '{raw['device']}'{nearest_hint(raw['device'], DEVICES)}"
        )
    return Slave(
        **_simple(Slave, raw, where),
        mailbox=_mailbox(raw.get("mailbox"), f"{where}: mailbox"),
        sync_managers=_sync_managers(raw.get("sync_managers"), f"{where}: sync_managers"),
        outputs=_pdos(raw.get("outputs"), f"{where}: outputs", busfile.OUTPUTS),
        inputs=_pdos(raw.get("inputs"), f"{where}: inputs", busfile.INPUTS),
        sdos=_sdos(raw.get("sdos"), f"{where}: sdos"),
        objects=_sdos(raw.get("objects"), f"{where}: objects"),
    )


def _mailbox(raw: Any, where: str) -> Mailbox | None:
    if raw is None or raw is False:
        return None
    raw = {} if raw is True else check_mapping(raw, where, Mailbox.__dataclass_fields__)
    return Mailbox(**_simple(Mailbox, raw, where, 0xFFFF))


def _sync_managers(raw: Any, where: str) -> SyncManagers | None:
    if raw is None:
        return None
    names = SyncManagers.__dataclass_fields__
    return SyncManagers(
        **_simple(SyncManagers, check_mapping(raw, where, names, names), where, 0xFFFF)
    )


def _pdos(raw: Any, where: str, known: frozenset[str]) -> tuple[Pdo, ...]:
    pdos = []
    for here, item in check_list(raw, where):
        check_mapping(
            item, here, ("pdo", "name", "assigned", "entries"), required=("pdo", "entries")
        )
        entries = check_list(item["entries"], f"{here}.entries")
        pdos.append(
            Pdo(
                entries=tuple(_entry(entry, at, known) for at, entry in entries),
                index=check_integer(item["pdo"], f"{here}: pdo", 0x1600, 0x1BFF),
                **_simple(Pdo, item, here),
            )
        )
    return tuple(pdos)


def _entry(raw: Any, where: str, known: frozenset[str]) -> Entry:
    keys = ("object", "type", "pad", "name", "channel", *_FACTS)
    check_mapping(raw, where, keys)
    channel = str(raw.get("channel", ""))
    if channel and channel not in known:
        raise BusFileError(f"{where}: unknown channel '{channel}'{nearest_hint(channel, known)}")
    if "pad" in raw:
        bits = check_integer(raw["pad"], f"{where}: pad", 1, 64)
        return Entry(0, 0, "", bits, name="padding", channel=channel)
    check_mapping(raw, where, keys, required=("object", "type"))
    place = parse_object(raw["object"], where)
    kind = str(raw["type"])
    if kind not in TYPES:
        raise BusFileError(f"{where}: unknown type '{kind}'{nearest_hint(kind, TYPES)}")
    entry = Entry(*place, kind, TYPES[kind][0], **_simple(Entry, raw, where, 2**31))
    _check_facts(entry, where)
    return entry


def _check_facts(entry: Entry, where: str) -> None:
    """Check that a channel with a unit has the raw facts for its scale."""
    if entry.channel in busfile.VOLTS and not (entry.full_scale_volts and entry.full_scale_counts):
        raise BusFileError(
            f"{where}: channel '{entry.channel}' needs full_scale_volts and full_scale_counts"
        )
    if entry.channel.rpartition(".")[2] in busfile.TORQUES and not entry.unit_nm:
        raise BusFileError(
            f"{where}: channel '{entry.channel}' needs unit_nm, the torque of one count"
        )


def parse_object(text: Any, where: str) -> tuple[int, int]:
    """Parse '0x6040:1' or 0x6040 to (index, subindex)."""
    head, _, tail = str(text).partition(":")
    return (
        check_integer(head, f"{where}: object", 0x1000, 0xFFFF),
        check_integer(tail or 0, f"{where}: object", 0, 255),
    )


def _sdos(raw: Any, where: str) -> tuple[SdoValue, ...]:
    values = []
    for here, item in check_list(raw, where):
        required = ("object", "type", "value")
        check_mapping(item, here, (*required, "name"), required)
        kind = str(item["type"])
        read = {"string": lambda value, _: str(value), OCTETS: check_octets}.get(kind)
        if kind not in TYPES and read is None:
            raise BusFileError(
                f"{here}: unknown type '{kind}'{nearest_hint(kind, [*TYPES, 'string', OCTETS])}"
            )
        value = (read or _check_wide)(item["value"], f"{here}: value")
        place = parse_object(item["object"], here)
        values.append(SdoValue(*place, kind, value, str(item.get("name", ""))))
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
