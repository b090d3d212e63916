# SPDX-License-Identifier: Apache-2.0
"""Damaged Parquet and MATLAB files."""

from __future__ import annotations

import io
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import scipy.io

from flatplank_data.parquet_files import write_checked
from flatplank_data.readers.base import Loaded, Request
from flatplank_data.readers.mat import variables
from flatplank_data.readers.parquet import read_parquet
from flatplank_data.store import LocalStore
from flatplank_validation.trust.files.judge import judged
from flatplank_validation.trust.files.matlab73 import write_mat73
from flatplank_validation.trust.registry import Options, Tally, row

NIGHT = 20_000
"""damaged files of a night"""
ROWS = 300
WRITTEN = {
    "time": 0.2 * np.arange(ROWS),
    "fx": np.sin(np.arange(ROWS)),
    "fz": 3700.0 + np.cos(np.arange(ROWS)),
}


@row(
    "parquet", "damaged Parquet tables (zstd, snappy, plain)",
    "not refused in one line, a value that was not written, or a column lost without a word",
)  # fmt: skip
def damaged_parquet(o: Options) -> Tally:
    """With page checksums, as they are written here, no value can be wrong."""

    def read(path: Path) -> Loaded:
        return read_parquet(Request(LocalStore(str(path.parent)), path.name))

    def compare(loaded: Loaded, _: Path) -> None:
        for name, values in loaded.columns.items():
            np.testing.assert_array_equal(values, WRITTEN[name])
        assert loaded.remarks or set(loaded.columns) == set(WRITTEN), list(loaded.columns)

    out = Tally()
    with tempfile.TemporaryDirectory(prefix="fp-parquet-") as folder:
        path = Path(folder) / "r.parquet"
        for packing in ("zstd", "snappy", "none"):
            if packing == "zstd":
                write_checked(pa.table(WRITTEN), path)
            else:
                table = pa.table(WRITTEN)
                pq.write_table(table, path, compression=packing, write_page_checksum=True)
            out.join(judged(o, NIGHT // 3, path, read, compare))
    return out


def mat(packed: bool = False, **values: Any) -> bytes:
    """A file of MATLAB version 5 or 7 by scipy."""
    stream = io.BytesIO()
    scipy.io.savemat(stream, values, do_compression=packed)
    return stream.getvalue()


RUN = {
    **WRITTEN, "units": {"time": "s", "fx": "kN", "fz": "N"}, "kappa": 0.05, "tire": "TOY",
    "names": np.array(["a", "bcd"], dtype=object), "grid": np.arange(6.0).reshape(2, 3),
    "flag": np.array([True, False]), "deep": {"a": {"b": 2.0}},
}  # fmt: skip


def _of_matlab(path: Path) -> Mapping[str, Any]:
    return variables(path.read_bytes(), path.name)


@row(
    "matlab", "damaged MATLAB files of version 5 (plain) and 7 (packed)",
    "not refused in one line, the program ended, or in a packed file a value that was not written",
)  # fmt: skip
def damaged_matlab(o: Options) -> Tally:
    """Some of them end the process that parses; never this one."""

    def compare(found: Mapping[str, Any], path: Path) -> None:
        if path.stem == "packed":  # checked by its packing
            for name in set(found) & set(WRITTEN):
                np.testing.assert_array_equal(found[name], WRITTEN[name])

    out = Tally()
    with tempfile.TemporaryDirectory(prefix="fp-matlab-") as folder:
        for name in ("plain", "packed"):
            path = Path(folder) / f"{name}.mat"
            path.write_bytes(mat(name == "packed", **RUN))
            out.join(judged(o, NIGHT // 2, path, _of_matlab, compare))
    return out


@row(
    "matlab73", "damaged MATLAB 7.3 files (plain, and with checksums)",
    "not refused in one line, the program ended, or with checksums a value that was not written "
    "or a variable lost",
)  # fmt: skip
def damaged_matlab73(o: Options) -> Tally:
    """A plain HDF5 file has no checksums: there a wrong bit in a value cannot be seen."""

    def compare(found: Mapping[str, Any], path: Path) -> None:
        for name in set(found) & set(WRITTEN):
            assert np.size(found[name]) in (ROWS, 0, 1), (
                f"{name} has {np.size(found[name])} values"
            )
        if path.stem == "checked":
            assert set(found) == {*WRITTEN, "tire"}, f"variables: {sorted(found)}"
            for name, values in WRITTEN.items():
                np.testing.assert_array_equal(found[name], values)

    out = Tally()
    with tempfile.TemporaryDirectory(prefix="fp-matlab73-") as folder:
        for name in ("plain", "checked"):
            path = Path(folder) / f"{name}.mat"
            write_mat73(path, {**WRITTEN, "tire": "TOY"}, checked=name == "checked")
            out.join(judged(o, NIGHT // 2, path, _of_matlab, compare))
    return out
