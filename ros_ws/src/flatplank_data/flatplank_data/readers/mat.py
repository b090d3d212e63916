# SPDX-License-Identifier: Apache-2.0
"""Reads MATLAB files of version 5 to 7.3: one variable per column, or one struct of columns.

A struct `units` with a text per column gives units; without it the file is in SI. A scalar named
like a key of campaign.yaml sets that key.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from flatplank_data.errors import FlatplankError
from flatplank_data.guard import DamagedError
from flatplank_data.native.parent import parse
from flatplank_data.readers.base import Loaded, Request, canonical_names, columns_in_si, reader
from flatplank_data.run_record import RunRecord
from flatplank_data.table import COLUMN_UNITS

_FACTS = {item.name for item in dataclasses.fields(RunRecord)}
_HDF5 = b"MATLAB 7.3"


@reader(".mat")
def read_mat(request: Request) -> Loaded:
    """Read a .mat file of version 5 to 7.3."""
    with request.store.open(request.name) as stream:
        values = _columns_of(variables(stream.read(), request.name))
    units = values.pop("units", {})
    arrays = {
        k: _real(v, k, request.name)
        for k, v in values.items()
        if isinstance(v, np.ndarray) and v.ndim == 1
    }
    names, remarks = canonical_names(arrays, request.mapping)

    def unit_of(name: str) -> str | None:
        unit = units.get(name) if isinstance(units, dict) else None
        if units and unit is None:
            what = f"column '{name}' has no unit while others have one"
            raise FlatplankError(what, request.name, f"add units.{name}")
        return unit or None

    columns = columns_in_si(names, request, arrays.__getitem__, unit_of, "variable")
    facts = {k: v for k, v in values.items() if k in _FACTS and isinstance(v, (int, float, str))}
    return Loaded(columns, facts, remarks)


def _real(values: np.ndarray, name: str, where: str) -> np.ndarray:
    """Values without an imaginary part; FlatplankError where it is not zero."""
    if not np.iscomplexobj(values):
        return values
    rows = np.flatnonzero(values.imag)
    if rows.size:
        what = f"'{name}' is complex, first {values[rows[0]]:g}"
        raise FlatplankError(what, f"{where}, row {rows[0] + 1}", "export its real part")
    return np.asarray(values.real)


def variables(data: bytes, where: str) -> dict[str, Any]:
    """Name -> value of a file of version 5 to 7.3; FlatplankError for any other file.

    Arrays of any shape, structs as mappings, cells as lists, numbers, texts. A damaged file can
    end the interpreter that parses it, so another process does.
    """
    try:
        found: dict[str, Any] = parse("matlab 7.3" if data.startswith(_HDF5) else "matlab", data)
    except DamagedError as error:
        raise FlatplankError(
            f"not a whole MATLAB file ({error})", where, "export or copy it again"
        ) from error
    return found


def _columns_of(values: dict[str, Any]) -> dict[str, Any]:
    structs = [v for k, v in values.items() if isinstance(v, dict) and k != "units"]
    if not any(name in values for name in COLUMN_UNITS) and len(structs) == 1:
        return {**values, **structs[0]}
    return values
