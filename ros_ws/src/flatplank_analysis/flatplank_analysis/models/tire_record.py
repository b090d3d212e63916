# SPDX-License-Identifier: Apache-2.0
"""The record of a mounted tire: one YAML file that every fit and report starts from.

```yaml
format: flatplank-tire/1
name: CON                       # as in the names of the run files
description: Continental EcoContact 6, 155/70 R19 84Q
free_radius: 0.350              # R0 [m]
width: 0.155                    # [m]
nominal_load: 3250.0            # [N]
nominal_pressure: 2.8           # [bar]
rim_radius: 0.2413              # [m]
rim: 5J x 19                    # text
mounted: 2023-03-01
start_file: continental.tir     # beside the record, or a shipped one
contact: {vertical_stiffness: 2.41e5, pressure_effect: 0.86, q_ra1: 0.877, q_ra2: 0.456}
placeholder: [width]            # numbers that nobody measured
source: data sheet
```

Required are name, free_radius, nominal_load, nominal_pressure.
"""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import Any

from flatplank_data.errors import FlatplankError
from flatplank_data.names import similar_names
from flatplank_data.yaml_text import dump_yaml, load_yaml
from flatplank_tire.tir import TIRE_FILES, TirFile, check_tir, parse_tir, read_tir

from .base import SPEED, ContactGeometry

FORMAT = "flatplank-tire/1"
FILE = "tire.yaml"
"""name of the record in a campaign folder"""
REQUIRED = ("name", "free_radius", "nominal_load", "nominal_pressure")
RANGES = {
    "free_radius": (0.1, 1.0, "m"),
    "width": (0.02, 1.0, "m"),
    "nominal_load": (50.0, 50e3, "N"),
    "nominal_pressure": (0.2, 15.0, "bar"),
    "rim_radius": (0.05, 0.8, "m"),
}
CONTACT = ("vertical_stiffness", "pressure_effect", "q_ra1", "q_ra2")
KEYS = dict(zip(("VERTICAL_STIFFNESS", "PFZ1", "Q_RA1", "Q_RA2"), CONTACT, strict=True))
"""coefficient of a `.tir` -> key of the contact geometry"""
TYPICAL_DEFLECTION = 0.05
"""deflection at nominal load, as a share of R0: 0.055 and 0.039 in thesis Table 7.2"""
TYPICAL = {"pressure_effect": 0.85, "q_ra1": 0.90, "q_ra2": 0.29}
"""means of both tires in thesis Table 7.2"""
PLACEHOLDER = "not measured and not in the tire record: placeholder, typical of a passenger tire"


@dataclass(frozen=True)
class TireRecord:
    """Properties of a mounted tire that are known before any fit. SI, pressure in bar."""

    name: str
    free_radius: float
    """R0 [m]"""
    nominal_load: float
    """[N]"""
    nominal_pressure: float
    """[bar]"""
    description: str = ""
    width: float = math.nan
    """[m]"""
    rim_radius: float = math.nan
    """[m]"""
    rim: str = ""
    mounted: str = ""
    """date"""
    start_file: str = ""
    """`.tir` with the start values of a fit; empty: general start values, of no tire"""
    contact: Mapping[str, float] = field(default_factory=dict)
    """some of `CONTACT`"""
    placeholder: tuple[str, ...] = ()
    """fields that nobody measured"""
    source: str = ""
    origin: str = ""
    """source of the record: a file, or how it was made"""

    def geometry(self) -> tuple[ContactGeometry, dict[str, str]]:
        """Contact geometry at the nominal load, and the source of each of its numbers."""
        stiffness = self.nominal_load / (TYPICAL_DEFLECTION * self.free_radius)
        known = {k: v for k, v in self.contact.items() if k in CONTACT}
        numbers = {"vertical_stiffness": stiffness, **TYPICAL, **known}
        source_text = f"not measured: tire record {self.name}" + (
            f", {self.source}" * bool(self.source)
        )
        sources = dict.fromkeys(CONTACT, PLACEHOLDER) | dict.fromkeys(known, source_text)
        for key in ("free_radius", "nominal_pressure"):
            sources[key] = PLACEHOLDER if key in self.placeholder else source_text
        pressure = 1e5 * self.nominal_pressure
        return ContactGeometry(self.free_radius, nominal_pressure=pressure, **numbers), sources

    def headline(self) -> str:
        """The record in one line."""
        text = f"R0 {self.free_radius:.4g} m, nominal {self.nominal_load:.0f} N"
        text += f" and {self.nominal_pressure:.3g} bar"
        text += f", {self.description}" * bool(self.description)
        return f"{self.name or 'without a name'}: {text} ({self.origin})"

    def to_yaml(self) -> str:
        """Text of the file; reading it returns the same record."""
        plain: dict[str, Any] = {"format": FORMAT}
        for item in dataclasses.fields(self):
            value = getattr(self, item.name)
            if item.name == "origin" or value in ("", (), {}) or value != value:
                continue
            if isinstance(value, (tuple, Mapping)):
                value = list(value) if isinstance(value, tuple) else dict(value)
            plain[item.name] = value
        return dump_yaml(plain)


def read_record(path: str | os.PathLike[str]) -> TireRecord:
    """The record in a file (YAML, or a `.tir` that becomes the start file), checked."""
    path = Path(path)
    if path.suffix.lower() == ".tir":
        return record_of_tir(read_tir(path), str(path))
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "is no text"
        raise FlatplankError(reason, str(path), "give a tire record (.yaml) or a .tir") from None
    record = parse_record(text, str(path))
    beside = path.parent / record.start_file
    if beside.is_file():
        record = dataclasses.replace(record, start_file=str(beside))
    return record


def parse_record(text: str, where: str) -> TireRecord:
    """Check keys and numbers of a record's text."""
    raw = load_yaml(text, where)
    if not isinstance(raw, Mapping) or raw.get("format") != FORMAT:
        raise FlatplankError(f"format is not {FORMAT}", where, f"begin with format: {FORMAT}")
    known = {f.name for f in dataclasses.fields(TireRecord)} - {"origin"}
    values = {str(k): v for k, v in raw.items() if k != "format"}
    for key in values:
        _known(key, known, where)
    missing = [key for key in REQUIRED if key not in values]
    if missing:
        raise FlatplankError(f"missing {', '.join(missing)}", where, "add it to the tire record")
    for key in RANGES:
        if key in values:
            values[key] = _within(key, values[key], where)
    for key in ("name", "description", "rim", "mounted", "start_file", "source"):
        if key in values:
            values[key] = str(values[key])
    contact = values.get("contact") or {}
    if not isinstance(contact, Mapping):
        raise FlatplankError("contact has no keys", where, f"some of {', '.join(CONTACT)}")
    for key in contact:
        _known(str(key), set(CONTACT), where)
    try:
        values["contact"] = {k: float(v) for k, v in contact.items()}
    except (TypeError, ValueError):
        raise FlatplankError("contact: not a number", where, "NAME: number, in SI") from None
    values["placeholder"] = tuple(str(v) for v in values.get("placeholder") or ())
    return TireRecord(**values, origin=where)


def _within(key: str, value: Any, where: str) -> float:
    low, high, unit = RANGES[key]
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not low <= number <= high:
        remedy = f"give {low:g} to {high:g} {unit}"
        raise FlatplankError(f"{key}: {value!r} is not in {unit}", where, remedy)
    return number


def _known(key: str, known: set[str], where: str) -> None:
    if key not in known:
        near = similar_names(key, known, 0.0)[0]
        raise FlatplankError(f"unknown key {key}", where, f"did you mean {near}?")


def shipped_record(name: str) -> TireRecord:
    """A shipped record, by its file's name without suffix."""
    file = resources.files("flatplank_analysis") / "tire_data" / f"{name}.yaml"
    if not file.is_file():
        raise FlatplankError(f"no record {name}", "tire records", "give a file")
    return parse_record(file.read_text(encoding="utf-8"), f"shipped record {name}")


def record_of_tir(tir: TirFile, path: str) -> TireRecord:
    """The record with the sizes, nominal values and contact geometry of a `.tir`."""
    c = tir.coefficients
    contact: dict[str, float] = {}
    if math.isfinite(c.VERTICAL_STIFFNESS):
        contact = {"vertical_stiffness": c.VERTICAL_STIFFNESS, "pressure_effect": c.PFZ1}
    if c.Q_RA1:
        contact |= {"q_ra1": c.Q_RA1, "q_ra2": c.Q_RA2}
    return TireRecord(
        Path(path).stem,
        c.UNLOADED_RADIUS,
        c.FNOMIN,
        1e-5 * c.NOMPRES,
        width=c.WIDTH or math.nan,
        rim_radius=c.RIM_RADIUS or math.nan,
        start_file=path,
        contact=contact,
        origin=path,
    )


def start_tir(record: TireRecord, general: Mapping[str, float]) -> TirFile:
    """Start of a Magic Formula fit: the record's file, or `general` start values.

    Radius, width, nominal load and pressure are always those of the record, and so is the contact
    geometry that the record has: the nonlinear model uses the same numbers.
    """
    text = TIRE_FILES / record.start_file
    if not record.start_file:
        tir = _general(record, general)
    elif Path(record.start_file).is_file():
        tir = read_tir(record.start_file)
    elif text.is_file():
        tir = parse_tir(text.read_text(encoding="utf-8"), record.start_file)
    else:
        what = f"start file {record.start_file} is not there"
        raise FlatplankError(what, record.origin, "correct start_file")
    numbers = {
        "UNLOADED_RADIUS": record.free_radius,
        "WIDTH": record.width,
        "RIM_RADIUS": record.rim_radius,
        "NOMPRES": 1e5 * record.nominal_pressure,
        "FNOMIN": record.nominal_load,
    } | {key: record.contact[name] for key, name in KEYS.items() if name in record.contact}
    tir = tir.replaced({k: v for k, v in numbers.items() if math.isfinite(v)})
    check_tir(tir)
    return tir


def _general(record: TireRecord, general: Mapping[str, float]) -> TirFile:
    units = "LENGTH='meter' FORCE='newton' ANGLE='radians' MASS='kg' TIME='second'"
    head = [f"COMMENT = '{record.name}, from general start values'"]
    lines = ["[MDI_HEADER]", "FILE_TYPE = 'tir'", *head, "[UNITS]", *units.split()]
    lines += ["[MODEL]", "FITTYP = 61", f"LONGVL = {SPEED:g}", "VXLOW = 0.0"]
    contact, _ = record.geometry()
    own = {key: getattr(contact, name) for key, name in KEYS.items()}
    return parse_tir("\n".join(lines), "general start values").replaced(dict(general) | own)
