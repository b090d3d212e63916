# SPDX-License-Identifier: Apache-2.0
"""Writes MATLAB 7.3 files as MATLAB does: HDF5 with a block before it, arrays transposed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np

HEADER = (
    b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Fri Nov 01 10:00:00 2024 HDF5 schema"
)
CHECKED, CHECKSUMS = "checked", {"chunks": True, "compression": "gzip", "fletcher32": True}
"""attribute of a file whose values have checksums, and how h5py writes them"""


def write_mat73(path: Path, values: dict[str, Any], checked: bool = False) -> Path:
    """Vectors as columns, texts, lists as cells, mappings as structs.

    checked: with the checksums of HDF5 over values (Fletcher, and that of their packing) and over
    all that describes them, so that no damage can give another value.
    """
    version = "latest" if checked else "earliest"
    with h5py.File(path, "w", userblock_size=512, libver=(version, "latest")) as file:
        if checked:
            file.attrs[CHECKED] = True
        for name, value in values.items():
            _write(file, file, name, value)
    with path.open("r+b") as stream:
        stream.write(HEADER.ljust(124) + b"\x00\x02IM")
    return path


def _write(file: h5py.File, folder: h5py.Group, name: str, value: Any) -> h5py.Dataset:
    if isinstance(value, dict):
        group = folder.create_group(name)
        group.attrs["MATLAB_class"] = np.bytes_("struct")
        for key, field in value.items():
            _write(file, group, key, field)
        return group
    if isinstance(value, list):
        cells = file.require_group("#refs#")
        found = [_write(file, cells, f"{name}{k}", cell) for k, cell in enumerate(value)]
        data = np.array([[cell.ref for cell in found]], dtype=h5py.ref_dtype)
        return _dataset(folder, name, data, "cell")
    if isinstance(value, str):
        return _dataset(
            folder, name, np.frombuffer(value.encode("utf-16-le"), "<u2")[:, None], "char"
        )
    return _dataset(folder, name, np.atleast_2d(np.asarray(value, dtype=float)), "double")


def _dataset(folder: h5py.Group, name: str, data: np.ndarray, kind: str) -> h5py.Dataset:
    checked = folder.file.attrs.get(CHECKED, False)
    item = folder.create_dataset(name, data=data, **(CHECKSUMS if checked else {}))
    item.attrs["MATLAB_class"] = np.bytes_(kind)
    return item
