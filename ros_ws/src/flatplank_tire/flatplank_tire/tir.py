# SPDX-License-Identifier: Apache-2.0
"""Tire property files (`.tir`): read, check, write.

The reader accepts what the tools of the field write: a key may be in two sections (MASS in [UNITS]
and in [INERTIA]), a value may be empty, other units are converted, a missing key gets its
documented default, with a remark. FITTYP determines the law, the version of the equations;
coefficients that the law does not have are named and not used. Unknown sections and keys are kept
in their order and written again. A contradiction is an error of one line.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from importlib import resources
from pathlib import Path

from flatplank_tire.errors import FlatplankError
from flatplank_tire.magic_formula import (
    DEFAULTS,
    FORCES,
    LATEST,
    NOT_OF,
    OLD,
    OTHER_NAMES,
    PAC2002,
    REQUIRED,
    SECTION_OF,
    Coefficients,
)
from flatplank_tire.magic_formula.coefficients import BY_PRESSURE, DIMENSIONS, UNITS, factor
from flatplank_tire.text import decode_text, lines_of

LAWS = {5: OLD, 6: OLD, 21: OLD, 51: OLD, 52: OLD, 60: LATEST, 61: LATEST, 62: LATEST}
"""FITTYP -> law of the Magic Formula"""
VERSIONS = {"5.2": 6, "6.1": 61, "6.2": 62}
"""version of the equations -> FITTYP of a new file"""
MOTORCYCLE = "PCY2"
"""coefficient that only the Magic Formula of motorcycles (MF-MCTyre, PAC_MC) has"""
OF_SPEED = ("Q_V1", "Q_V2", "QSY3", "QSY4")
"""coefficients of the speed over LONGVL"""
LISTED = (
    "LONGITUDINAL_COEFFICIENTS", "LATERAL_COEFFICIENTS", "ALIGNING_COEFFICIENTS",
    "SCALING_COEFFICIENTS",
)  # fmt: skip
"""sections whose missing coefficients are named in a remark"""
_LINE = re.compile(r"^\s*([A-Za-z_]\w*)\s*=\s*('[^']*'|\"[^\"]*\"|[^$!]*)")


@dataclass(frozen=True)
class Entry:
    """One key of a file: the value as written, its position, and a remark to be written."""

    value: str
    line: int = 0
    remark: str = ""


@dataclass(frozen=True)
class TirFile:
    """A tire property file: sections with their entries, other lines kept as text."""

    sections: Mapping[str, Mapping[str, Entry]]
    kept: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    path: str = ""

    @property
    def entries(self) -> dict[str, Entry]:
        """Entries with a value; for a key in two sections, the entry of its proper section."""
        out: dict[str, Entry] = {}
        for name, section in self.sections.items():
            for key, entry in section.items():
                if entry.value and (key not in out or SECTION_OF.get(key) == name):
                    out[key] = entry
        return out

    @property
    def units(self) -> dict[str, float]:
        """Factor to SI of each quantity that [UNITS] names; unknown units count as SI."""
        given = self.sections.get("UNITS", {})
        return {
            q: names.get(_text(given[q]).lower(), 1.0) for q, names in UNITS.items() if q in given
        }

    @property
    def values(self) -> dict[str, float]:
        """The Magic Formula coefficients in the file [SI]."""
        units, given = self.units, self.entries
        named = {own: given[k] for k, own in OTHER_NAMES.items() if k in given} | given
        return {
            k: factor(k, units) * _number(k, e, self.path)
            for k, e in named.items()
            if k in SECTION_OF
        }

    @property
    def coefficients(self) -> Coefficients:
        """Coefficients ready for use; missing ones have their null values."""
        given = self.values
        # before 6.0 a nominal pressure is not required: without it no pressure acts
        usual = {} if self.law == LATEST else {"NOMPRES": given.get("INFLPRES") or 1e5}
        return Coefficients(usual | given, self.law)

    @property
    def law(self) -> str:
        """The law of the coefficients by FITTYP, otherwise by the coefficients present."""
        given = self.entries
        law = OLD if NOT_OF[LATEST] & given.keys() else LATEST
        if "FITTYP" in given:
            law = LAWS.get(int(_number("FITTYP", given["FITTYP"], self.path)), LATEST)
        kind = _text(given.get("PROPERTY_FILE_FORMAT", Entry(""))).upper()
        return PAC2002 if kind == PAC2002 and (law == OLD or "FITTYP" not in given) else law

    def replaced(self, values: Mapping[str, float]) -> TirFile:
        """A copy with changed or further coefficients, given in SI."""
        units = self.units
        sections = {name: dict(entries) for name, entries in self.sections.items()}
        home = {key: name for name, entries in sections.items() for key in entries}
        for key, value in values.items():
            own = SECTION_OF.get(key, "USER")
            section = own if key in sections.get(own, {}) else home.get(key, own)
            number = float(value) / factor(key, units)
            sections.setdefault(section, {})[key] = Entry(repr(number))
        return TirFile(sections, self.kept, self.path)

    def of_version(self, version: str) -> TirFile:
        """A copy that states a version of the equations, one of `VERSIONS`."""
        model = {**self.sections.get("MODEL", {}), "FITTYP": Entry(str(VERSIONS[version]))}
        return TirFile({**self.sections, "MODEL": model}, self.kept, self.path)

    def remarked(self, remarks: Mapping[str, str]) -> TirFile:
        """A copy with remarks beside coefficients, as comments of the written file."""
        sections = {
            name: {k: replace(e, remark=remarks.get(k, e.remark)) for k, e in section.items()}
            for name, section in self.sections.items()
        }
        return TirFile(sections, self.kept, self.path)

    def warnings(self, vx: float = 1.0) -> list[str]:
        """Remarks for a user of this file, one line each; vx: road speed [m/s]."""
        return list(_warnings(self, vx))


def read_tir(path: str | Path) -> TirFile:
    """Read and check a file; errors name the line."""
    try:
        text = decode_text(Path(path).read_bytes(), str(path))
    except OSError as error:
        what = error.strerror or "cannot be read"
        raise FlatplankError(what, str(path), "give a .tir") from None
    tir = parse_tir(text, str(path))
    check_tir(tir)
    return tir


def parse_tir(text: str, path: str = "") -> TirFile:
    """Parse the text of a file; a key with two values in one section is an error."""
    sections: dict[str, dict[str, Entry]] = {}
    kept: dict[str, list[str]] = {}
    name = ""
    for number, line in enumerate(lines_of(text), start=1):
        stripped = line.strip()
        if not stripped or stripped[0] in "!$":
            continue
        if stripped.startswith("["):
            name = stripped.strip("[]").split("]")[0].strip().upper()
            sections.setdefault(name, {})
            continue
        match = _LINE.match(line)
        if match is None:
            kept.setdefault(name, []).append(stripped)
            continue
        key = match[1].upper()
        section, value = sections.setdefault(name, {}), match[2].strip()
        before = section.get(key)
        if before is not None and before.value and value and before.value != value:
            what = f"{key} stands twice, first in line {before.line}"
            raise FlatplankError(what, f"{path} line {number}", "remove one of the two")
        if before is None or value:
            section[key] = Entry(value, number)
    return TirFile(sections, {k: tuple(v) for k, v in kept.items()}, path)


def check_tir(tir: TirFile) -> None:
    """Raise when units, formula version, numbers or required keys are wrong."""
    for what, entry, remedy in _faults(tir):
        where = f"{tir.path} line {entry.line}" if entry else tir.path or "tire file"
        raise FlatplankError(what, where, remedy)


def _faults(tir: TirFile) -> Iterator[tuple[str, Entry | None, str]]:
    """Faults: what is wrong, where, and what to do."""
    entries = tir.entries
    for unit, names in UNITS.items():
        entry = tir.sections.get("UNITS", {}).get(unit)
        if entry and _text(entry) and _text(entry).lower() not in names:
            yield f"unit of {unit} is {_text(entry)}", entry, f"known are {', '.join(names)}"
    found: dict[str, Entry] = {}
    for section in tir.sections.values():
        for key, entry in section.items():
            if key not in SECTION_OF or not entry.value:
                continue
            other = found.setdefault(key, entry)
            if _number(key, other, tir.path) != _number(key, entry, tir.path):
                what = f"{key} is {other.value} in line {other.line} and {entry.value} here"
                yield what, entry, "remove one of the two"
    version = entries.get("FITTYP")
    if version and _number("FITTYP", version, tir.path) not in LAWS:
        what = f"FITTYP = {version.value} is not Magic Formula 5.2 or 6.0 to 6.2"
        yield what, version, "convert the file to FITTYP = 61"
    if MOTORCYCLE in entries:
        what = f"{MOTORCYCLE} is of the Magic Formula of motorcycles"
        yield what, entries[MOTORCYCLE], "give a file of a car tire, FITTYP 6 or 60 to 62"
    values = tir.values
    missing = [k for k in _needed(tir) if k not in values]
    if missing:
        yield f"missing {', '.join(missing)}", None, f"add to section [{SECTION_OF[missing[0]]}]"
    positive = ["UNLOADED_RADIUS", "FNOMIN", "NOMPRES", "VERTICAL_STIFFNESS", "LFZO", "Q_RE0"]
    positive += ["LONGVL"] if any(values.get(key) for key in OF_SPEED) else []
    theirs = {own: name for name, own in OTHER_NAMES.items() if name in entries}
    for key in positive:
        if values.get(key, 1.0) <= 0.0:
            name = theirs.get(key, key)
            unit = "SI units" if key in DIMENSIONS else "a number above zero"
            yield f"{name} = {values[key]:g} is not positive", entries[name], f"give it in {unit}"


def _needed(tir: TirFile) -> list[str]:
    """Coefficients that this file must have: of every force that it has a part of, else of Fx."""
    begun = [f for f, keys in FORCES.items() if any(k in tir.values for k in keys)] or ["Fx"]
    usual = [k for k in REQUIRED if k != "NOMPRES" or tir.law == LATEST]
    return usual + [key for force in begun for key in FORCES[force]]


def write_tir(tir: TirFile, path: str | Path) -> None:
    """Write the file; a file read, written and read again has the same entries."""
    Path(path).write_text(format_tir(tir), encoding="utf-8")


def format_tir(tir: TirFile) -> str:
    """Text of the file, sections in their order."""
    lines: list[str] = list(tir.kept.get("", ()))
    lines += [f"{key:<24}= {entry.value}" for key, entry in tir.sections.get("", {}).items()]
    for name in dict.fromkeys([*tir.sections, *tir.kept]):
        if not name:
            continue
        lines += ["", f"[{name}]"]
        for key, entry in tir.sections.get(name, {}).items():
            remark = f"  $ {entry.remark}" if entry.remark else ""
            lines.append(f"{key:<24}= {entry.value}{remark}")
        lines += list(tir.kept.get(name, ()))
    return "\n".join(lines).lstrip("\n") + "\n"


def _warnings(tir: TirFile, vx: float) -> Iterator[str]:
    c, given = tir.coefficients, tir.values
    if abs(vx) < c.VXLOW:
        yield (
            f"VXLOW = {c.VXLOW:g} m/s is above the speed of {abs(vx):g} m/s: many tools scale the "
            "slip down there; it is not scaled here, set VXLOW = 0"
        )
    if c.PKY2 == 0.0:
        yield "PKY2 = 0: the load of the largest cornering stiffness is zero, taken as the limit"
    for force, needed in FORCES.items():
        zero = [key for key in needed if getattr(c, key) == 0.0]
        if len(zero) == len(needed):
            yield f"no {', '.join(zero)}: {force} and its stiffness are not known"
        elif zero:
            yield f"{', '.join(zero)} = 0: {force} is zero but for its shifts; is it a template?"
    if not c.has_moment:
        yield "no coefficient of the aligning moment (QDZ., SSZ.): Mz is not known"
    for stiffness, own, length in (
        ("LONGITUDINAL_STIFFNESS", c.PTX1, "sigma_x"),
        ("LATERAL_STIFFNESS", c.PTY1, "sigma_y"),
    ):
        if not (given.get(stiffness, 0.0) > 0.0 or own):
            yield f"{stiffness} is missing: {length} is not known"
    if not c.VERTICAL_STIFFNESS > 0.0:
        yield "VERTICAL_STIFFNESS is missing: R_e and the contact length are not known"
    elif not (c.Q_RA1 or c.Q_RA2):
        yield "Q_RA1 and Q_RA2 are missing: the contact length is not known"
    if "UNITS" not in tir.sections:
        yield "[UNITS] is missing: all numbers are taken as SI"
    angle = tir.sections.get("UNITS", {}).get("ANGLE")
    if angle and _text(angle).lower().startswith("deg"):
        yield "ANGLE is in degrees: coefficients are per radian all the same, as tools write them"
    others = [f"{q} {_text(tir.sections['UNITS'][q])}" for q, f in tir.units.items() if f != 1.0]
    if others:
        yield f"converted to SI from {', '.join(others)}"
    if "FITTYP" not in tir.entries:
        yield f"FITTYP is missing: taken as Magic Formula {tir.law}"
    foreign = [k for k in given if k in NOT_OF[tir.law] and given[k] != DEFAULTS[k]]
    if foreign:
        other = 6 if tir.law == LATEST else 61
        yield (
            f"Magic Formula {tir.law} has no {', '.join(foreign)}: not used; write FITTYP = "
            f"{other} if the file was fitted with the other one"
        )
    if tir.law == PAC2002 and "NOMPRES" not in given and any(given.get(k) for k in BY_PRESSURE):
        yield "IP_NOM is missing: the inflation pressure changes nothing"
    if not any(given.get(key) for key in ("RBX1", "RBY1")):
        yield "RBX1 and RBY1 are missing: combined slip does not reduce the forces"
    absent = [k for k in DEFAULTS if k not in given and DEFAULTS[k] == DEFAULTS[k]]
    absent = [k for k in absent if k not in NOT_OF[tir.law]]
    plain = [k for k in absent if SECTION_OF[k] in LISTED]
    if plain:
        yield f"not in the file, taken with their defaults: {', '.join(plain)}"
    unknown = [k for k in tir.sections.get("", {}) if k not in DEFAULTS]
    if unknown:
        yield f"keys before the first section are kept but not used: {', '.join(unknown)}"


def _text(entry: Entry) -> str:
    return entry.value.strip("'\" \t")


def _number(key: str, entry: Entry, path: str) -> float:
    try:
        number = float(entry.value)
        # an entry made by a program (line 0) may be NaN, unknown; one of a file may not
        good = math.isfinite(number) or not entry.line
    except ValueError:
        good = False
    if good:
        return number
    raise FlatplankError(
        f"{key} = {entry.value} is not a number", f"{path} line {entry.line}", "correct the line"
    )


TIRE_FILES = resources.files("flatplank_tire") / "tire_files"
"""folder of the files that come with the package"""
SHIPPED = ("toyo_nanoenergy", "continental_ecocontact")


def shipped_tir(name: str = SHIPPED[0]) -> TirFile:
    """A parameter set that comes with the package (thesis Table I.1)."""
    file = TIRE_FILES / f"{name}.tir"
    return parse_tir(file.read_text(encoding="utf-8"), f"{name}.tir")
