# SPDX-License-Identifier: Apache-2.0
"""Columns of a file of sweeps as written, by its suffix."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from flatplank_analysis.slip_sweeps.channels import channel_named
from flatplank_data.delimited import read_text_table
from flatplank_data.errors import FlatplankError
from flatplank_data.readers.mat import variables
from flatplank_tire.numbers import number_of
from flatplank_tire.text import decode_text
from flatplank_tire.tydex import parse_tydex


class Raw(NamedTuple):
    """Columns and units as in the file."""

    columns: Mapping[str, np.ndarray]
    """shape (samples,); NaN for no number"""
    units: Mapping[str, str]
    first: Callable[[str, np.ndarray], str]
    """name of a column and a mask of its rows -> the cell and the place of the first"""
    said: Sequence[str] = ()
    """remarks, one line each"""


def _text(data: bytes, where: str) -> Raw:
    table = read_text_table(data, where, lambda name: channel_named(name) is not None)
    columns, said = {}, list(table.remarks)
    for name in table.names:
        known = channel_named(name)
        try:
            if known == "time":
                columns[name] = table.time(name)
                continue
            values, other = table.column(name)
        except FlatplankError as error:
            if known not in (None, "time"):
                raise
            said.append(f"column '{name}' was left out: {error.what}")
            continue
        if other.all() and known is None:
            said.append(f"column '{name}' is text and was left out")
            continue
        if other.any():
            said.append(f"column '{name}': {table.not_numbers(name, other)}")
        columns[name] = values
    return Raw(columns, table.units, table.first, said)


def _tydex(data: bytes, where: str) -> Raw:
    """Channels, and the constants that a channel may be."""
    file = parse_tydex(decode_text(data, where), where)
    columns = {c.name: file.data[:, k] for k, c in enumerate(file.channels)}
    units = {c.name: c.unit for c in file.channels}
    held = {channel_named(name) for name in columns}
    for name, quantity in file.constants.items():
        channel, value = channel_named(name), number_of(quantity.value)
        if channel is None or channel in held or value is None:
            continue
        columns[name] = np.full(len(file.data), value)
        units[name] = quantity.unit
    said = [f"column '{name}': {cells}" for name, cells in file.not_numbers.items()]
    return Raw(columns, {k: v for k, v in units.items() if v}, _sample, said)


def _mat(data: bytes, where: str) -> Raw:
    values = variables(data, where)
    named = {k: v for k, v in values.items() if k not in ("channel", "units")}
    structs = [v for v in named.values() if isinstance(v, dict) and len(v) > 3]
    if len(structs) == 1 and not _vectors(values):
        values = {**values, **structs[0]}
    vectors = _vectors(values)
    longest = max(map(len, vectors.values()), default=0)
    said = [
        f"'{name}' was left out: {len(v)} values, other columns have {longest}"
        for name, v in vectors.items()
        if 1 < len(v) < longest
    ]
    columns = {name: v for name, v in vectors.items() if len(v) == longest}
    return Raw(columns, _mat_units(values), _sample, said)


def _sample(name: str, rows: np.ndarray) -> str:
    return f"in sample {int(np.argmax(rows)) + 1}"


def _vectors(values: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """The numeric vectors."""
    return {
        k: np.asarray(v, dtype=np.float64)
        for k, v in values.items()
        if isinstance(v, np.ndarray) and v.ndim == 1 and v.dtype.kind in "fiu"
    }


def _mat_units(values: Mapping[str, Any]) -> dict[str, str]:
    """Units from a struct `channel` with lists `name` and `units`, or `units` with text per
    name."""
    channel, units = values.get("channel"), values.get("units")
    if isinstance(channel, dict) and {"name", "units"} <= channel.keys():
        names, texts = np.atleast_1d(channel["name"]), np.atleast_1d(channel["units"])
        return {str(n): str(u) for n, u in zip(names, texts, strict=False) if str(u).strip()}
    return {str(k): str(v) for k, v in units.items()} if isinstance(units, dict) else {}


RAW: dict[str, Callable[[bytes, str], Raw]] = {
    ".mat": _mat,
    ".csv": _text,
    ".dat": _text,
    ".txt": _text,
    ".tsv": _text,
    ".asc": _text,
    ".tdx": _tydex,
    ".tydex": _tydex,
}
"""suffix -> reader"""
