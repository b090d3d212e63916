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
from dataclasses import MISSING, dataclass, field
from importlib import resources
from pathlib import Path
from typing import Any

from flatplank_data.errors import FlatplankError
from flatplank_data.params import NO_KEY, from_mapping, param
from flatplank_data.yaml_text import dump_yaml, load_format
from flatplank_tire.tir import TIRE_FILES, TirFile, check_tir, parse_tir, read_tir

from .base import SPEED, ContactGeometry

FORMAT = "flatplank-tire/1"
FILE = "tire.yaml"
"""name of the record in a campaign folder"""
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
    free_radius: float = param(MISSING, "R0", unit="m", bounds=(0.1, 1.0))
    nominal_load: float = param(MISSING, "load", unit="N", bounds=(50.0, 50e3))
    nominal_pressure: float = param(MISSING, "pressure", unit="bar", bounds=(0.2, 15.0))
    description: str = ""
    width: float = param(math.nan, "of the tire", unit="m", bounds=(0.02, 1.0))
    rim_radius: float = param(math.nan, "of the rim", unit="m", bounds=(0.05, 0.8))
    rim: str = ""
    mounted: str = ""
    """date"""
    start_file: str = ""
    """`.tir` with the start values of a fit; empty: general start values, of no tire"""
    contact: Mapping[str, float] = field(default_factory=dict, metadata={"choices": CONTACT})
    placeholder: tuple[str, ...] = ()
    """fields that nobody measured"""
    source: str = ""
    origin: str = field(default="", metadata=NO_KEY)
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
    raw = load_format(text, where, FORMAT)
    given = {key: value for key, value in raw.items() if value is not None}
    return dataclasses.replace(from_mapping(TireRecord, given, where), origin=where)


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
