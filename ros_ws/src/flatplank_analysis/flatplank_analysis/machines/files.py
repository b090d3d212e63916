# SPDX-License-Identifier: Apache-2.0
"""Tables over time from log files of machines: CSV, `.mat`, JSON."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from flatplank_data.errors import FlatplankError
from flatplank_data.readers.mat import variables


def read_table(path: str | os.PathLike[str]) -> pd.DataFrame:
    """The columns of a file as a table; `table.attrs` has the single values of a `.mat` or JSON
    file.

    `.csv`, `.txt`, `.dat`: a line of names, then numbers or words. `.mat`: vectors of equal
    length, or Simulink signals with their time (column `time`), and single values. `.json`: a list
    of rows, or an object whose longest list has the rows.
    """
    where = Path(path)
    reader = READERS.get(where.suffix.lower())
    if reader is None:
        remedy = f"known are {', '.join(READERS)}"
        raise FlatplankError(f"'{where.suffix}' is no kind of file", str(where), remedy)
    try:
        table = reader(where)
    except FileNotFoundError:
        raise FlatplankError("no such file", str(where), "check the path") from None
    except Exception as error:  # external readers raise many kinds of errors
        first = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise FlatplankError(f"cannot be read: {first}", str(where), "check the file") from None
    if table.empty:
        raise FlatplankError("holds no table", str(where), "columns of one length are wanted")
    return table


def column(table: pd.DataFrame, *names: str, where: str = "table") -> np.ndarray:
    """The first of these columns that a table has, in upper or lower case, as numbers."""
    has = {str(c).strip().lower(): c for c in reversed(table.columns)}
    for name in names:
        if name.lower() in has:
            try:
                return np.asarray(table[has[name.lower()]], dtype=float)
            except (TypeError, ValueError):
                raise FlatplankError(
                    f"column {name} holds no numbers", where, "correct the column"
                ) from None
    remedy = f"it has {', '.join(map(str, table.columns))}"
    raise FlatplankError(f"no column {' or '.join(names)}", where, remedy)


def _csv(path: Path) -> pd.DataFrame:
    table = pd.read_csv(path, skipinitialspace=True)
    # semicolons, tabs and blanks, too
    return table if table.shape[1] > 1 else pd.read_csv(path, sep=None, engine="python")


def _mat(path: Path) -> pd.DataFrame:
    found: dict[str, np.ndarray] = {}
    beside: dict[str, Any] = {}
    for name, value in variables(path.read_bytes(), path.name).items():
        if isinstance(value, Mapping) and isinstance(value.get("signals"), Mapping):
            found["time"] = np.atleast_1d(value["time"])
            found[name] = np.atleast_1d(value["signals"]["values"])
        elif isinstance(value, np.ndarray) and value.ndim == 1 and len(value) > 1:
            found[name] = value
        elif isinstance(value, str) or np.size(value) == 1:
            beside[name] = np.asarray(value).reshape(-1)[0].item()
    length = max(map(len, found.values()), default=0)
    table = pd.DataFrame({k: v for k, v in found.items() if len(v) == length})
    table.attrs = beside
    return table


def _json(path: Path) -> pd.DataFrame:
    data = json.loads(path.read_text(encoding="utf-8"))
    beside: dict[str, Any] = {}
    if isinstance(data, Mapping):
        lists = {k: v for k, v in data.items() if isinstance(v, list)}
        rows = max(lists, key=lambda k: len(lists[k]))
        beside, data = {k: v for k, v in data.items() if not isinstance(v, list)}, lists[rows]
    table = pd.DataFrame(data)
    table.attrs = beside
    return table


READERS: dict[str, Callable[[Path], pd.DataFrame]] = {
    ".csv": _csv, ".txt": _csv, ".dat": _csv, ".mat": _mat, ".json": _json,
}  # fmt: skip
