# SPDX-License-Identifier: Apache-2.0
"""Tire property files (`.tir`): read, check, write.

Unknown sections and keys are kept, in their order, and written again. Lengths, forces and angles
must be in m, N, rad. A key given twice or a missing one is an error of one line.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from ..errors import FlatplankError
from .magic_formula import DEFAULTS, REQUIRED, SECTION_OF, Coefficients

UNITS: dict[str, frozenset[str]] = {
    "LENGTH": frozenset({"meter", "metre", "m"}),
    "FORCE": frozenset({"newton", "n"}),
    "ANGLE": frozenset({"radians", "radian", "rad"}),
    "MASS": frozenset({"kg", "kilogram"}),
    "TIME": frozenset({"second", "sec", "s"}),
    "PRESSURE": frozenset({"pascal", "pa"}),
}
FORMULAS = {60, 61, 62}
_LINE = re.compile(r"^\s*([A-Za-z_]\w*)\s*=\s*('[^']*'|\"[^\"]*\"|[^$!]*)")


@dataclass(frozen=True)
class Entry:
    """One key of a file: the value as written, and where."""

    value: str
    line: int = 0


@dataclass(frozen=True)
class TirFile:
    """A tire property file: sections with their entries, other lines kept as text."""

    sections: Mapping[str, Mapping[str, Entry]]
    kept: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    path: str = ""

    @property
    def entries(self) -> dict[str, Entry]:
        """All entries, whatever their section."""
        return {k: e for section in self.sections.values() for k, e in section.items()}

    @property
    def values(self) -> dict[str, float]:
        """The coefficients of the Magic Formula that the file gives."""
        given = self.entries
        return {k: _number(k, e, self.path) for k, e in given.items() if k in SECTION_OF}

    @property
    def coefficients(self) -> Coefficients:
        """Coefficients ready for use; what is not given has its null value."""
        return Coefficients(self.values)

    def replaced(self, values: Mapping[str, float]) -> TirFile:
        """The same file with other or more coefficients."""
        sections = {name: dict(entries) for name, entries in self.sections.items()}
        home = {key: name for name, entries in sections.items() for key in entries}
        for key, value in values.items():
            section = home.get(key) or SECTION_OF.get(key, "USER")
            sections.setdefault(section, {})[key] = Entry(repr(float(value)))
        return TirFile(sections, self.kept, self.path)

    def warnings(self, vx: float = 0.03) -> list[str]:
        """What a user of this file should know, one line each."""
        return list(_warnings(self, vx))


def read_tir(path: str | Path) -> TirFile:
    """Read and check a file; errors name the line."""
    try:
        text = Path(path).read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise FlatplankError(
            error.strerror or "cannot be read", str(path), "give a .tir"
        ) from None
    tir = parse_tir(text, str(path))
    check_tir(tir)
    return tir


def parse_tir(text: str, path: str = "") -> TirFile:
    """Take the text of a file apart; a key that stands twice is an error."""
    sections: dict[str, dict[str, Entry]] = {}
    kept: dict[str, list[str]] = {}
    seen: dict[str, int] = {}
    name = ""
    for number, line in enumerate(text.splitlines(), start=1):
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
        if key in seen:
            raise FlatplankError(
                f"{key} stands twice, first in line {seen[key]}",
                f"{path} line {number}",
                "remove one of the two",
            )
        seen[key] = number
        sections.setdefault(name, {})[key] = Entry(match[2].strip(), number)
    return TirFile(sections, {k: tuple(v) for k, v in kept.items()}, path)


def check_tir(tir: TirFile) -> None:
    """Raise when units, formula version, numbers or required keys are not right."""
    entries = tir.entries
    for unit, names in UNITS.items():
        entry = tir.sections.get("UNITS", {}).get(unit)
        if entry and _text(entry).lower() not in names:
            raise FlatplankError(
                f"unit of {unit} is {_text(entry)}",
                f"{tir.path} line {entry.line}",
                f"convert the file to {sorted(names, key=len)[-1]}",
            )
    version = entries.get("FITTYP")
    if version and _number("FITTYP", version, tir.path) not in FORMULAS:
        raise FlatplankError(
            f"FITTYP = {version.value} is not Magic Formula 6.1 or 6.2",
            f"{tir.path} line {version.line}",
            "convert the file to FITTYP = 61",
        )
    missing = [key for key in REQUIRED if key not in entries]
    if missing:
        first = f"[{SECTION_OF[missing[0]]}]"
        raise FlatplankError(
            f"missing {', '.join(missing)}", tir.path or "tire file", f"add to section {first}"
        )
    for key, value in tir.values.items():
        if key in ("UNLOADED_RADIUS", "FNOMIN", "NOMPRES", "VERTICAL_STIFFNESS") and value <= 0:
            raise FlatplankError(
                f"{key} = {value:g} is not positive",
                f"{tir.path} line {entries[key].line}",
                "give it in SI units",
            )


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
        lines += [f"{k:<24}= {e.value}" for k, e in tir.sections.get(name, {}).items()]
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
    for stiffness, length in (
        ("LONGITUDINAL_STIFFNESS", "sigma_x"),
        ("LATERAL_STIFFNESS", "sigma_y"),
    ):
        if not given.get(stiffness, 0.0) > 0.0:
            yield f"{stiffness} is missing: {length} is not known"
    if "FITTYP" not in tir.entries:
        yield "FITTYP is missing: taken as Magic Formula 6.1"
    if not any(given.get(key) for key in ("RBX1", "RBY1")):
        yield "RBX1 and RBY1 are missing: combined slip does not reduce the forces"
    unknown = [k for k in tir.sections.get("", {}) if k not in DEFAULTS]
    if unknown:
        yield f"keys before the first section are kept but not used: {', '.join(unknown)}"


def _text(entry: Entry) -> str:
    return entry.value.strip("'\" \t")


def _number(key: str, entry: Entry, path: str) -> float:
    try:
        return float(entry.value)
    except ValueError:
        raise FlatplankError(
            f"{key} = {entry.value} is not a number", f"{path} line {entry.line}", "mend it"
        ) from None
