# SPDX-License-Identifier: Apache-2.0
"""Writes Parquet files with checksums, keeps tables in one step, names damaged files."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from flatplank_data.errors import FlatplankError

KEPT = ".flatplank-cache"
"""folder of kept tables beside what they were made from; it may be deleted"""


def write_checked(table: pa.Table, path: Path) -> None:
    """Write a table with page checksums."""
    pq.write_table(table, path, compression="zstd", use_dictionary=False, write_page_checksum=True)


def keep(table: pa.Table, path: Path) -> bool:
    """Replace a kept table in one step; False where it cannot be written (read-only disk)."""
    part = path.with_name(f"{path.name}.{os.getpid()}.part")
    try:
        path.parent.mkdir(exist_ok=True)
        write_checked(table, part)
        os.replace(part, path)
    except OSError:
        with suppress(OSError):
            part.unlink()
        return False
    return True


@contextmanager
def whole(name: str) -> Iterator[None]:
    """Turns what the Parquet library raises on a damaged file into FlatplankError."""
    try:
        yield
    except FlatplankError:
        raise
    except (pa.ArrowException, OSError, ValueError, LookupError, MemoryError) as error:
        raise FlatplankError(
            f"not a whole Parquet file ({error})", name, "export or copy it again"
        ) from error
