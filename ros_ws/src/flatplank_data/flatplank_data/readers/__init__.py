# SPDX-License-Identifier: Apache-2.0
"""Readers; importing this package registers them all."""

from flatplank_data.readers import bag, csv, mat, parquet, tydex
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
    "bag",
    "csv",
    "read_description",
    "mat",
    "parquet",
    "reader",
    "reader_for",
    "suffixes",
    "tydex",
]
