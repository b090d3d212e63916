# SPDX-License-Identifier: Apache-2.0
"""Variables of MATLAB 7.3 files, which are HDF5; arrays in them are transposed."""

from __future__ import annotations

import io
from typing import Any

import numpy as np

DEEPEST = 8
"""levels of structs and cells; a damaged file may refer to itself"""


def matlab73(data: bytes) -> dict[str, Any]:
    """Name -> value as scipy gives those of older files: vectors, texts, structs as mappings.

    Raises what h5py raises on a damaged file, and ImportError without h5py.
    """
    import h5py

    with h5py.File(io.BytesIO(data), "r") as file:
        return {name: _value(file, item, 0) for name, item in file.items() if name[0] != "#"}


def _value(file: Any, item: Any, depth: int) -> Any:
    """A variable, a field of a struct, or a cell."""
    if depth > DEEPEST:
        raise ValueError("structs and cells too deep")
    if hasattr(item, "items"):
        return {name: _value(file, field, depth + 1) for name, field in item.items()}
    kind = bytes(item.attrs.get("MATLAB_class", b"")).decode("ascii", "replace")
    if item.attrs.get("MATLAB_empty", 0):
        return "" if kind == "char" else np.empty(0)
    values = np.squeeze(item[()].T)
    if kind == "char":
        return values.astype("<u2").tobytes().decode("utf-16-le").rstrip("\0")
    if values.dtype.kind == "O":  # a cell, or a field of an array of structs
        cells = [_value(file, file[reference], depth + 1) for reference in values.ravel()]
        return cells if values.shape else cells[0]
    return values if values.shape else values.item()
