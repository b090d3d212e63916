# SPDX-License-Identifier: Apache-2.0
"""Writes tables to files, one exporter per suffix; the readers of this package can read them."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv as pc

from flatplank_data.campaign import CAMPAIGN_FILE, FORMAT
from flatplank_data.condition import is_nan
from flatplank_data.errors import FlatplankError
from flatplank_data.files import write_atomic
from flatplank_data.mdf import write_mdf4
from flatplank_data.naming import name_of, numbered
from flatplank_data.parquet_files import write_checked
from flatplank_data.readers.parquet import INFO_KEY
from flatplank_data.readers.tydex import CHANNELS, CONSTANTS
from flatplank_data.run_record import RunRecord
from flatplank_data.table import COLUMN_UNITS, MeasurementTable
from flatplank_data.yaml_text import dump_yaml
from flatplank_tire.tydex import Channel, Quantity, TydexFile, format_tydex


def write_parquet(table: MeasurementTable, path: Path) -> None:
    """Write float64 columns, units as field metadata, the run record as schema metadata."""
    fields = [
        pa.field(name, pa.float64(), metadata={"unit": COLUMN_UNITS.get(name, "1")})
        for name in table.columns
    ]
    record = json.dumps(table.info.to_dict(), default=str).encode()
    schema = pa.schema(fields, metadata={INFO_KEY: record})
    arrays = [pa.array(values) for values in table.columns.values()]
    write_checked(pa.table(arrays, schema=schema), path)


def write_csv(table: MeasurementTable, path: Path) -> None:
    """Write a header with units and numbers with full precision."""
    names = [f"{name} [{COLUMN_UNITS.get(name, '1')}]" for name in table.columns]
    arrow = pa.table([pa.array(values) for values in table.columns.values()], names=names)
    pc.write_csv(arrow, path, pc.WriteOptions(quoting_style="none"))


def write_tydex(table: MeasurementTable, path: Path) -> None:
    """Write TYDEX 1.3; nine characters per number, so about seven digits."""
    names = {ours: theirs for theirs, ours in reversed(CHANNELS.items())}
    used = [name for name in table.columns if name in names]
    channels = [
        Channel(names[n], {"1": "-"}.get(COLUMN_UNITS[n], COLUMN_UNITS[n]), note=n) for n in used
    ]
    data = np.column_stack([table[name] for name in used])
    info = table.info
    header = {
        "RELEASE": "1.3",
        "MEASID": info.uuid or info.name,
        "SUPPLIER": info.operator,
        "DATE": info.date,
    }
    comments = [f"flat plank measurement {info.name}", *info.notes.splitlines()]
    file = TydexFile(header, comments, _constants(info), tuple(channels), data)
    path.write_text(format_tydex(file), encoding="latin-1", errors="replace")


def _constants(info: RunRecord) -> dict[str, Quantity]:
    units = {"kappa": "-", "pressure": "bar", "alpha_deg": "deg", "gamma_deg": "deg"}
    out = {}
    for key, (ours, si, _) in CONSTANTS.items():
        value = getattr(info, ours)
        if not is_nan(value):
            unit = units.get(ours, {"1": "-"}.get(si, si))
            out[key] = Quantity(unit, f"{value:.10g}", ours)
    return out


EXPORTERS: dict[str, Callable[[MeasurementTable, Path], None]] = {
    ".parquet": write_parquet,
    ".csv": write_csv,
    ".tdx": write_tydex,
    ".mf4": write_mdf4,
}


def export_campaign(
    tables: Iterable[MeasurementTable], folder: str | os.PathLike[str], suffix: str = ".parquet"
) -> Path:
    """Write tables and their campaign.yaml; returns the folder."""
    write = EXPORTERS.get(suffix)
    if write is None:
        known = ", ".join(EXPORTERS)
        raise FlatplankError(f"no exporter for '{suffix}'", os.fspath(folder), f"use {known}")
    out = Path(folder)
    out.mkdir(parents=True, exist_ok=True)
    runs = []
    for table in tables:
        name = table.info.name or numbered(name_of(vars(table.info)), table.info.repeat)
        write(table, out / f"{name}{suffix}")
        runs.append(table.info.to_dict() | {"file": f"{name}{suffix}"})
    content = {"format": FORMAT, "tire": runs[0]["tire"] if runs else "", "runs": runs}
    write_atomic(out / CAMPAIGN_FILE, dump_yaml(content))
    return out
