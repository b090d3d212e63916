# SPDX-License-Identifier: Apache-2.0
"""Readers; importing this package registers those of every file in its folder."""

import importlib
import pkgutil

from flatplank_data.readers.base import (
    Loaded,
    Request,
    read_description,
    reader,
    reader_for,
    suffixes,
)

__all__ = [
    "Loaded",
    "Request",
    "read_description",
    "reader",
    "reader_for",
    "suffixes",
]

for _file in pkgutil.iter_modules(__path__):
    importlib.import_module(f"{__name__}.{_file.name}")
