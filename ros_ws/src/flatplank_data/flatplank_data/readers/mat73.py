# SPDX-License-Identifier: Apache-2.0
"""Reads variables of MATLAB 7.3 files, which are HDF5; arrays in them are transposed."""

from __future__ import annotations

import io
from typing import Any

import numpy as np

from flatplank_data.errors import FlatplankError

SIGNATURE = b"MATLAB 7.3"
DEEPEST = 8
"""levels of structs and cells; a damaged file may refer to itself"""


def variables_of_hdf5(data: bytes, where: str) -> dict[str, Any]:
    """Name -> value as scipy gives those of older files: vectors, texts, structs as dicts.

    Raises:
        FlatplankError: the package h5py is missing, or the file is not whole.
    """
    try:
        import h5py
    except ImportError:
        raise FlatplankError(
            "MATLAB version 7.3 needs the package h5py", where, "pip install h5py, or save '-v7'"
        ) from None
    try:
        with h5py.File(io.BytesIO(data), "r") as file:
            return {name: _value(file, item, 0) for name, item in file.items() if name[0] != "#"}
    except Exception as error:  # h5py raises many types of errors on a damaged file
        raise FlatplankError(
            f"not a whole MATLAB file ({error})", where, "export or copy it again"
        ) from error


def _value(file: Any, item: Any, depth: int) -> Any:
    """A variable, field or cell."""
    if depth > DEEPEST:
        raise ValueError("structs and cells too deep")
    if hasattr(item, "items"):
        return {name: _value(file, field, depth + 1) for name, field in item.items()}
    kind = item.attrs.get("MATLAB_class", b"").decode("ascii", "replace")
    if item.attrs.get("MATLAB_empty", 0):
        return "" if kind == "char" else np.empty(0)
    values = np.squeeze(item[()].T)
    if kind == "char":
        return values.astype(np.uint16).tobytes().decode("utf-16-le").rstrip("\0")
    if values.dtype.kind == "O":  # a cell, or a field of an array of structs
        cells = np.empty(values.size, dtype=object)
        cells[:] = [_value(file, file[reference], depth + 1) for reference in values.ravel()]
        return cells.reshape(values.shape) if values.shape else cells[0]
    return values if values.shape else values.item()
