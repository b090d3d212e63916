# SPDX-License-Identifier: Apache-2.0
"""Reads a file of sweeps: `.mat`, or text with commas, semicolons, tabs or blanks."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from flatplank_analysis.slip_sweeps.channels import (
    BY_NAME,
    channel_of,
    check_columns,
    in_si,
    sizes,
)
from flatplank_data.errors import FlatplankError
from flatplank_data.readers.csv import split_header
from flatplank_data.readers.mat import variables

LEAST = 50
"""least number of samples of a sweep"""


Raw = tuple[Mapping[str, np.ndarray], Mapping[str, str]]
"""columns and units as in the file"""


@dataclass(frozen=True)
class Recording:
    """Measured channels, in the axes of the file."""

    path: str
    columns: Mapping[str, np.ndarray]
    """known channels by the names of `CHANNELS`, in SI; the others unchanged"""
    further: tuple[str, ...]
    """names of the other columns"""
    said: tuple[str, ...]
    """assumptions, one line each"""


def read(path: str | Path) -> Recording:
    """Read a file of sweeps. Raises FlatplankError for a file that cannot be used."""
    where = str(path)
    reader = _READERS.get(Path(path).suffix.lower())
    if reader is None:
        known = ", ".join(_READERS)
        raise FlatplankError("not a file of sweeps", where, f"give one of {known}")
    try:
        raw, units = reader(Path(path).read_bytes(), where)
    except OSError as error:
        raise FlatplankError(error.strerror or "cannot be read", where, "give a file") from None
    found = channel_of(list(raw))
    check_columns(list(found), where)
    columns = {name: np.asarray(raw[theirs], float) for name, theirs in found.items()}
    size, said = sizes(columns), []
    for name, theirs in found.items():
        place, unit = f"{where}, '{theirs}'", units.get(theirs)
        columns[name], remark = in_si(BY_NAME[name], columns[name], unit, size[name], place)
        said += [remark] if remark else []
    taken = set(found.values())
    further = {k: v for k, v in raw.items() if k not in taken}
    whole = np.all([np.isfinite(columns[n]) for n in columns], axis=0)
    if whole.sum() < LEAST:
        raise FlatplankError(
            f"{int(whole.sum())} whole samples", where, f"a sweep needs {LEAST} at least"
        )
    if not whole.all():
        said.append(f"{int((~whole).sum())} of {len(whole)} samples have gaps and are left out")
    kept = {k: np.asarray(v, float)[whole] for k, v in {**columns, **further}.items()}
    return Recording(where, kept, tuple(further), tuple(said))


def _mat(data: bytes, where: str) -> Raw:
    values = variables(data, where)
    structs = [v for v in values.values() if isinstance(v, dict) and len(v) > 3]
    if len(structs) == 1 and not _vectors(values):
        values = {**values, **structs[0]}
    return _vectors(values), _mat_units(values)


def _vectors(values: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """The numeric vectors of the usual length."""
    arrays = {
        k: v
        for k, v in values.items()
        if isinstance(v, np.ndarray) and v.ndim == 1 and v.dtype.kind in "fiu"
    }
    if not arrays:
        return {}
    longest = max(len(v) for v in arrays.values())
    return {k: v for k, v in arrays.items() if len(v) == longest}


def _mat_units(values: Mapping[str, Any]) -> dict[str, str]:
    """Units from a struct `channel` with lists `name` and `units`, or `units` with text per
    name."""
    channel, units = values.get("channel"), values.get("units")
    if isinstance(channel, dict) and {"name", "units"} <= channel.keys():
        names, texts = np.atleast_1d(channel["name"]), np.atleast_1d(channel["units"])
        return {str(n): str(u) for n, u in zip(names, texts, strict=False) if str(u).strip()}
    return {str(k): str(v) for k, v in units.items()} if isinstance(units, dict) else {}


def _text(data: bytes, where: str) -> Raw:
    lines = data.decode("utf-8-sig", "replace").splitlines()
    numbers = [n for n, line in enumerate(lines) if _row(line) is not None]
    if not numbers:
        raise FlatplankError("no line of numbers", where, "write a header and one line per sample")
    first = numbers[0]
    rows = [_row(lines[n]) or [] for n in numbers]
    width = len(rows[0])
    wrong = next((n for n, row in zip(numbers, rows, strict=True) if len(row) != width), None)
    if wrong is not None:
        raise FlatplankError(
            f"{len(_row(lines[wrong]) or [])} values where the first line has {width}",
            f"{where}, line {wrong + 1}", "correct or remove the line",
        )  # fmt: skip
    head = [cells for n in range(first) if len(cells := _cells(lines[n])) == width]
    if not head:
        raise FlatplankError(
            f"no header of {width} names before line {first + 1}", where, "write one"
        )
    names, given = split_header(head[0])
    units = {name: unit for name, unit in zip(names, given, strict=True) if unit}
    if len(head) > 1 and not units:
        units = dict(zip(names, (u.strip("[]() ") for u in head[1]), strict=True))
    table = np.array(rows, float)
    return {name: table[:, i] for i, name in enumerate(names)}, units


def _cells(line: str) -> list[str]:
    mark = next((m for m in ("\t", ";", ",") if m in line), None)
    return [cell.strip().strip('"') for cell in (line.split(mark) if mark else line.split())]


def _row(line: str) -> list[float] | None:
    """The numbers of a line; None when it has other text."""
    cells = _cells(line.replace(",", ".") if ";" in line else line)
    if len(cells) < 3:
        return None
    try:
        return [float(cell or "nan") for cell in cells]
    except ValueError:
        return None


_READERS: dict[str, Callable[[bytes, str], Raw]] = {
    ".mat": _mat,
    ".csv": _text,
    ".dat": _text,
    ".txt": _text,
}
