# SPDX-License-Identifier: Apache-2.0
"""Reads Parquet tables: one file per run, units in the field metadata, else SI.

Durations and timestamps carry their unit themselves. Page checksums are verified where the file
has them, as those have that are written here.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
import pyarrow.types as kinds

from flatplank_data.errors import FlatplankError
from flatplank_data.guard import Budget
from flatplank_data.parquet_files import whole
from flatplank_data.readers.base import (
    Loaded,
    Request,
    canonical_names,
    columns_in_si,
    describer,
    reader,
)
from flatplank_data.store import Store
from flatplank_data.table import COLUMN_UNITS

INFO_KEY = b"flatplank.run"
_PER_SECOND = {"s": 1, "ms": 10**3, "us": 10**6, "ns": 10**9}


@reader(".parquet")
def read_parquet(request: Request) -> Loaded:
    """Read the wanted columns only."""
    with request.store.open(request.name) as stream, whole(request.name):
        file = pq.ParquetFile(stream, page_checksum_verification=True)
        schema = file.schema_arrow
        _check(file, schema, request)
        names, remarks = canonical_names(schema.names, request.mapping, request.further)
        names = {t: o for t, o in names.items() if o in COLUMN_UNITS or _numeric(schema, t)}
        wanted = {t: o for t, o in names.items() if request.wants(o)}
        table = file.read(columns=list(wanted), use_threads=False)
        facts = _facts(schema.metadata)
    columns = columns_in_si(
        wanted,
        request,
        lambda name: _numbers(table.column(name), wanted[name], f"{request.name}, '{name}'"),
        lambda name: _unit(schema.field(name), request.name),
    )
    return Loaded(columns, facts, remarks)


@describer(".parquet")
def describe_parquet(store: Store, name: str) -> dict:
    """The run record in the schema metadata of our own exports."""
    with store.open(name) as stream, whole(name):
        return _facts(pq.read_schema(stream).metadata)


def _check(file: pq.ParquetFile, schema: pa.Schema, request: Request) -> None:
    """Refuse a file that unpacks to too much, and one with two columns of one name."""
    size = request.store.size_and_time(request.name)[0]
    Budget.of(request.name, size).take(8 * file.metadata.num_rows * len(schema.names))
    twice = next((n for n in schema.names if schema.names.count(n) > 1), None)
    if twice is not None:
        raise FlatplankError(f"two columns '{twice}'", request.name, "remove one of them")


def _numbers(column: pa.ChunkedArray, ours: str, where: str) -> np.ndarray:
    """Values as float64; time in s, since the first one where stamps are absolute."""
    kind = column.type
    if kinds.is_dictionary(kind):
        column, kind = column.cast(kind.value_type), kind.value_type
    if COLUMN_UNITS.get(ours) == "s" and (kinds.is_timestamp(kind) or kinds.is_duration(kind)):
        ticks = _since_first(column.cast(pa.int64())) if kinds.is_timestamp(kind) else column
        return _floats(ticks.cast(pa.int64())) / _PER_SECOND[kind.unit]
    if COLUMN_UNITS.get(ours) == "s" and kinds.is_integer(kind):
        exact = pc.max(pc.abs(column.cast(pa.int64(), safe=False))).as_py() or 0
        return _floats(column if exact < 2**53 else _since_first(column))
    if not (_is_number(kind) or kinds.is_boolean(kind) or kinds.is_null(kind)):
        what = f"its type is {kind}, which is no number of {COLUMN_UNITS.get(ours) or 'any unit'}"
        raise FlatplankError(what, where, "export it as floating-point numbers")
    return _floats(column)


def _floats(column: pa.ChunkedArray) -> np.ndarray:
    return np.asarray(column.cast(pa.float64(), safe=False).to_numpy(), dtype=np.float64)


def _since_first(column: pa.ChunkedArray) -> pa.ChunkedArray:
    found = column.drop_null()
    return pc.subtract(column, found[0]) if len(found) else column


def _is_number(kind: pa.DataType) -> bool:
    return kinds.is_floating(kind) or kinds.is_integer(kind) or kinds.is_decimal(kind)


def _unit(field: pa.Field, where: str) -> str | None:
    """Unit of a column; a duration or stamp is converted to s by its own type."""
    unit = (field.metadata or {}).get(b"unit")
    stated = unit.decode("utf-8", "replace") if unit is not None else None
    if kinds.is_duration(field.type) or kinds.is_timestamp(field.type):
        if stated not in (None, "s", field.type.unit):
            what = f"its unit is '{stated}', its type {field.type}"
            raise FlatplankError(what, f"{where}, '{field.name}'", "correct one of them")
        return None
    return stated


def _numeric(schema: pa.Schema, name: str) -> bool:
    kind = schema.field(name).type
    return kinds.is_floating(kind) or kinds.is_integer(kind)


def _facts(metadata: dict[bytes, bytes] | None) -> dict[str, Any]:
    raw = (metadata or {}).get(INFO_KEY)
    facts = json.loads(raw) if raw else {}
    if not isinstance(facts, dict):
        raise ValueError("its run record is no mapping")
    return facts
