# SPDX-License-Identifier: Apache-2.0
"""The Parquet file of a catalogue: its columns, and how it is read.

Read without the package that reads campaigns, and without pandas: a selection is to take less than
a second.
"""

from __future__ import annotations

import json
import os
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from flatplank_data.errors import FlatplankError
from flatplank_data.parquet_files import KEPT, keep, whole
from flatplank_data.run_record import UNITS

FILE = "catalogue.parquet"
FORMAT = "flatplank-catalogue/1"
STAMPS = b"flatplank.catalogue"
"""key of the metadata: format, and the stamp of every folder"""
Stamps = Mapping[str, str]

OF_THE_RECORD = {
    "tire": pa.string(), "serial": pa.string(), "name": pa.string(), "uuid": pa.string(),
    "kappa": pa.float64(), "fz": pa.float64(), "pressure": pa.float64(), "alpha_deg": pa.float64(),
    "gamma_deg": pa.float64(), "speed": pa.float64(), "start": pa.int64(), "repeat": pa.int64(),
    "run_index": pa.int64(), "effective_rolling_radius": pa.float64(), "operator": pa.string(),
    "status": pa.string(), "cycles_lost": pa.int64(), "software_version": pa.string(),
    "notes": pa.string(),
}  # fmt: skip
"""keys of the run record that are columns under their own name"""
DERIVED = ("folder", "file", "kind", "date", "bench", "quality", "verdict", "effects", "error")
"""texts: folder relative to the root, its file, kind of measurement, date (ISO 8601, empty: not
stated), bench, quality as in the panel, verdict and named effects of the diagnosis, and why a run
cannot be used"""
SCHEMA = pa.schema(
    [
        pa.field(name, kind, metadata={"unit": UNITS[name]} if name in UNITS else None)
        for name, kind in {**dict.fromkeys(DERIVED, pa.string()), **OF_THE_RECORD}.items()
    ]
)


@dataclass(frozen=True)
class Update:
    """What bringing a catalogue up to date has done."""

    table: pa.Table
    """columns of `SCHEMA`, a row per run, in the order of the folders"""
    stamps: Stamps
    read: Sequence[str] = ()
    """folders that are new or have changed"""
    gone: Sequence[str] = ()
    """folders that are no longer there"""
    kept: bool = True
    """False: the file could not be written, and is made anew each time"""


def file_of(root: str | os.PathLike[str]) -> Path:
    """The Parquet file of a catalogue; it may be deleted."""
    return Path(root) / KEPT / FILE


def stored(root: str | os.PathLike[str], columns: Collection[str] | None = None) -> Update | None:
    """The catalogue as it was kept; None where there is none, or one that cannot be read.

    columns: those to read, by default all.
    """
    path = file_of(root)
    names = [n for n in SCHEMA.names if columns is None or n in columns]
    try:
        with whole(str(path)), pq.ParquetFile(path) as file:
            said = json.loads((file.schema_arrow.metadata or {})[STAMPS])
            if said["format"] != FORMAT:
                return None
            # threads take more time than they save: the file is of some megabytes
            table = file.read(columns=names, use_threads=False)
            return Update(table.cast(pa.schema(SCHEMA.field(n) for n in names)), said["folders"])
    except (FlatplankError, KeyError, TypeError):
        return None


def store(root: str, table: pa.Table, stamps: Stamps) -> bool:
    """Keep a catalogue; False where it cannot be written."""
    text = json.dumps({"format": FORMAT, "folders": stamps}).encode()
    return keep(table.replace_schema_metadata({STAMPS: text}), file_of(root))
