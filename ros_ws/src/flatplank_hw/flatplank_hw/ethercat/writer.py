# SPDX-License-Identifier: Apache-2.0
"""Writes dataclasses to a bus file in YAML; reading it again gives the same bus."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import yaml

from flatplank_hw.ethercat.busfile import FORMAT, BusFile, Entry, Mailbox, Pdo, SdoValue, Slave


class Hex(int):
    """An integer that is written as hexadecimal."""


class _Dumper(yaml.SafeDumper):
    """Block style outside, one line per entry."""


class _Row(dict[str, Any]):
    """A mapping on one line."""


_Dumper.add_representer(
    Hex, lambda d, v: d.represent_scalar("tag:yaml.org,2002:int", f"0x{int(v):08X}")
)
_Dumper.add_representer(
    _Row, lambda d, v: d.represent_mapping("tag:yaml.org,2002:map", v.items(), flow_style=True)
)


def write_bus(bus: BusFile) -> str:
    """The text of a bus file."""
    top = {
        "format": FORMAT,
        "name": bus.name,
        "rate_hz": bus.rate_hz,
        "watchdog_ms": bus.watchdog_ms,
        "command_timeout_ms": bus.command_timeout_ms,
        "slaves": [slave_mapping(s) for s in bus.slaves],
    }
    head = "# SPDX-License-Identifier: Apache-2.0\n"
    return head + yaml.dump(top, Dumper=_Dumper, sort_keys=False, width=98, allow_unicode=True)


def slave_mapping(slave: Slave) -> dict[str, Any]:
    """Convert one slave to plain data; default values are left out."""
    out: dict[str, Any] = {"name": slave.name, "device": slave.device}
    for key in ("vendor", "product", "revision"):
        out[key] = Hex(getattr(slave, key))
    flags = ("write_assignment", "write_mapping")
    for key in ("check_revision", "placeholder", "axis", "dc", *flags):
        if getattr(slave, key):
            out[key] = getattr(slave, key)
    if slave.serial:
        out["serial"] = Hex(slave.serial)
    if slave.mailbox is not None:
        out["mailbox"] = True if slave.mailbox == Mailbox() else _numbers(asdict(slave.mailbox))
    if slave.sync_managers is not None:
        out["sync_managers"] = _numbers(asdict(slave.sync_managers))
    for key in ("outputs", "inputs"):
        if getattr(slave, key):
            out[key] = [_pdo(p) for p in getattr(slave, key)]
    for key in ("sdos", "objects"):
        if getattr(slave, key):
            out[key] = [_sdo(s) for s in getattr(slave, key)]
    return out


def _numbers(values: dict[str, Any]) -> _Row:
    return _Row({k: v if isinstance(v, bool) else Hex(v) for k, v in values.items()})


def _pdo(pdo: Pdo) -> dict[str, Any]:
    out: dict[str, Any] = {"pdo": Hex(pdo.index)}
    if pdo.name:
        out["name"] = pdo.name
    if not pdo.assigned:
        out["assigned"] = False
    out["entries"] = [_entry(e) for e in pdo.entries]
    return out


def _entry(entry: Entry) -> _Row:
    if not entry.index:
        row = _Row(pad=entry.bits)
        if entry.channel:
            row["channel"] = entry.channel
        return row
    row = _Row(object=f"0x{entry.index:04X}:{entry.subindex}", type=entry.kind)
    for key in ("channel", "full_scale_volts", "full_scale_counts", "unit_nm", "name"):
        if getattr(entry, key):
            row[key] = getattr(entry, key)
    return row


def _sdo(sdo: SdoValue) -> _Row:
    row = _Row(object=f"0x{sdo.index:04X}:{sdo.subindex}", type=sdo.kind, value=sdo.value)
    if sdo.name:
        row["name"] = sdo.name
    return row
