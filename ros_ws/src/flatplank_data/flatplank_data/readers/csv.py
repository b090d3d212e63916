# SPDX-License-Identifier: Apache-2.0
"""Reads CSV tables: one header line; units as `fx [N]` or in a second line; without units SI."""

from __future__ import annotations

import io
import re

import numpy as np
import pyarrow as pa
import pyarrow.csv as pc

from flatplank_data.errors import FlatplankError
from flatplank_data.readers.base import Loaded, Request, canonical_names, columns_in_si, reader
from flatplank_data.units import is_number_text

_BRACKETS = re.compile(r"^\s*(.*?)\s*[\[(]([^\])]*)[\])]\s*$")
_SEPARATORS = (",", ";", "\t")


@reader(".csv")
def read_csv(request: Request) -> Loaded:
    """Read a table; lines that start with '#' are comments."""
    with request.store.open(request.name) as stream:
        text = stream.read()
    lines, skipped = _header_lines(text, request.name)
    separator = max(_SEPARATORS, key=lambda s: lines[0].count(s))
    names, units = split_header(lines[0].split(separator))
    rows_before = skipped + 1
    second = [cell.strip() for cell in lines[1].split(separator)] if len(lines) > 1 else []
    if second and not any(units) and not is_number_text(second[0]):
        units = [cell.strip("[]() ") for cell in second]
        rows_before += 1
    _check_units(names, units, request.name)
    table = _parse(text, separator, names, rows_before, request.name)
    ours, remarks = canonical_names(names, request.mapping, request.further)
    unit_of = dict(zip(names, units, strict=True))
    columns = columns_in_si(ours, request, table.__getitem__, lambda name: unit_of[name] or None)
    return Loaded(columns, {}, remarks)


def _header_lines(text: bytes, name: str) -> tuple[list[str], int]:
    """Header, the line after it, and the number of comment lines before."""
    found: list[str] = []
    skipped = 0
    for line in io.TextIOWrapper(io.BytesIO(text), encoding="utf-8-sig", errors="replace"):
        line = line.rstrip("\r\n")
        if not found and (line.startswith("#") or not line.strip()):
            skipped += 1
            continue
        found.append(line)
        if len(found) == 2:
            return found, skipped
    raise FlatplankError("no samples", name, "write a header line and one line per sample")


def split_header(cells: list[str]) -> tuple[list[str], list[str]]:
    """Names and units of a header: `fx [N]`; a name without brackets has the unit ""."""
    names, units = [], []
    for cell in cells:
        match = _BRACKETS.match(cell.strip().strip('"'))
        names.append(match.group(1) if match else cell.strip().strip('"'))
        units.append((match.group(2) or "-") if match else "")
    return names, units


def _check_units(names: list[str], units: list[str], file: str) -> None:
    """Check that all columns have a unit, or none (then the file is in SI)."""
    if len(units) != len(names):
        raise FlatplankError(
            f"{len(units)} units for {len(names)} columns", f"{file}, line 2", "give each a unit"
        )
    if any(units) and not all(units):
        missing = names[units.index("")]
        raise FlatplankError(
            f"column '{missing}' has no unit while others have one",
            f"{file}, header",
            f"write it as '{missing} [unit]', or give no unit at all for a file in SI",
        )


def _parse(
    text: bytes, separator: str, names: list[str], skip: int, file: str
) -> dict[str, np.ndarray]:
    try:
        table = pc.read_csv(
            io.BytesIO(text),
            read_options=pc.ReadOptions(column_names=names, skip_rows=skip, use_threads=False),
            parse_options=pc.ParseOptions(delimiter=separator),
            convert_options=pc.ConvertOptions(
                column_types=dict.fromkeys(names, pa.float64()),
                null_values=["", "nan", "NaN", "NA"],
                decimal_point="," if separator == ";" and b"." not in text[:20000] else ".",
            ),
        )
    except pa.ArrowException as error:
        row, what = _bad_row(text, separator, names, skip)
        raise FlatplankError(
            what or f"cannot be read ({error})",
            f"{file}, line {row}" if row else file,
            "correct or remove the line",
        ) from error
    return {name: table.column(name).to_numpy() for name in names}


def _bad_row(text: bytes, separator: str, names: list[str], skip: int) -> tuple[int, str]:
    """Number of the first line that does not parse, and why."""
    for number, line in enumerate(text.decode("utf-8", "replace").splitlines(), start=1):
        if number <= skip or not line.strip():
            continue
        cells = line.split(separator)
        if len(cells) != len(names):
            return number, f"{len(cells)} values for {len(names)} columns (cut short?)"
        for name, cell in zip(names, cells, strict=True):
            if cell.strip() and not is_number_text(cell.replace(",", ".")):
                return number, f"'{cell.strip()}' in column '{name}' is not a number"
    return 0, ""
