# SPDX-License-Identifier: Apache-2.0
"""Readers; importing this package registers them all."""

from flatplank_analysis.data.readers import bag, csv, parquet
from flatplank_analysis.data.readers.base import Loaded, Request, reader, reader_for, suffixes

__all__ = ["Loaded", "Request", "bag", "csv", "parquet", "reader", "reader_for", "suffixes"]
