# SPDX-License-Identifier: Apache-2.0
"""Reads Parquet tables: one file per run, units in the field metadata, else SI."""

from __future__ import annotations

import json

import pyarrow as pa
import pyarrow.parquet as pq

from flatplank_data.errors import FlatplankError
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


@reader(".parquet")
def read_parquet(request: Request) -> Loaded:
    """Read the wanted columns only."""
    with request.store.open(request.name) as stream:
        try:
            file = pq.ParquetFile(stream)
            schema = file.schema_arrow
            names, remarks = canonical_names(schema.names, request.mapping, request.further)
            names = {t: o for t, o in names.items() if o in COLUMN_UNITS or _numeric(schema, t)}
            wanted = {t: o for t, o in names.items() if request.wants(o)}
            table = file.read(columns=list(wanted), use_threads=False)
        except (pa.ArrowException, OSError, ValueError) as error:
            raise FlatplankError(
                f"not a whole Parquet file ({error})", request.name, "export or copy it again"
            ) from error
    columns = columns_in_si(
        wanted,
        request,
        lambda name: table.column(name).to_numpy(),
        lambda name: _unit(schema.field(name)),
    )
    return Loaded(columns, _facts(schema.metadata), remarks)


@describer(".parquet")
def describe_parquet(store: Store, name: str) -> dict:
    """The run record in the schema metadata of our own exports."""
    with store.open(name) as stream:
        try:
            return _facts(pq.read_schema(stream).metadata)
        except (pa.ArrowException, OSError, ValueError):
            return {}


def _unit(field: pa.Field) -> str | None:
    unit = (field.metadata or {}).get(b"unit")
    return unit.decode() if unit is not None else None


def _numeric(schema: pa.Schema, name: str) -> bool:
    kind = schema.field(name).type
    return pa.types.is_floating(kind) or pa.types.is_integer(kind)


def _facts(metadata: dict[bytes, bytes] | None) -> dict:
    raw = (metadata or {}).get(INFO_KEY)
    return json.loads(raw) if raw else {}
