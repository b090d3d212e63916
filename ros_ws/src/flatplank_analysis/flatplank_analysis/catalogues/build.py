# SPDX-License-Identifier: Apache-2.0
"""Keeps the catalogue of a folder: one Parquet file, in which only what changed is read again.

The unit of reading is a campaign folder: its rows stay while no file of it changes. The metadata
of the Parquet file have the stamp of every folder.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import pyarrow as pa
import pyarrow.compute as pc

from flatplank_analysis.catalogues.kept import SCHEMA, Update, store, stored
from flatplank_analysis.catalogues.rows import DIAGNOSIS, Row, rows_of
from flatplank_analysis.parallel import open_executor
from flatplank_analysis.report.analysis import Progress
from flatplank_data.errors import FlatplankError
from flatplank_data.folders import campaign_folders, stamp_of
from flatplank_data.naming import FOLDERS as PARTS


def updated(
    root: str | os.PathLike[str],
    *,
    jobs: int | None = 1,
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> Update:
    """The catalogue of all campaign folders below `root`, brought up to date and kept.

    Raises FlatplankError when `root` is no folder.
    """
    base = os.fspath(root)
    if not os.path.isdir(base):
        raise FlatplankError("no such folder", base, "give a folder with campaigns below it")
    before = stored(base) or Update(SCHEMA.empty_table(), {})
    stamps = {folder: _stamp(Path(base, folder)) for folder in _folders(base)}
    read = [f for f in stamps if before.stamps.get(f) != stamps[f]]
    gone = [f for f in before.stamps if f not in stamps]
    if not read and not gone:
        return before
    rows: list[Row] = []
    with open_executor(jobs, scheduler) as executor:
        for done, found in enumerate(executor.map(partial(rows_of, base), read), start=1):
            rows += found
            if progress:
                progress(done, len(read), read[done - 1])
    table = _joined(before.table, rows, {*read, *gone})
    return Update(table, stamps, read, gone, store(base, table, stamps))


def _folders(base: str) -> list[str]:
    """Campaign folders without those of Appendix F, whose runs belong to the folder above."""
    found = dict(campaign_folders(base))
    return [f for f in found if os.path.basename(f) not in PARTS or _above(f) not in found]


def _above(folder: str) -> str:
    return os.path.dirname(folder) or os.curdir


def _joined(old: pa.Table, rows: Sequence[Row], changed: set[str]) -> pa.Table:
    """Rows of the unchanged folders and the new ones."""
    stays = pc.invert(pc.is_in(old["folder"], pa.array(sorted(changed), pa.string())))
    new = pa.Table.from_pylist(list(rows), SCHEMA)
    return pa.concat_tables([old.filter(stays), new]).sort_by("folder")


def _stamp(folder: Path) -> str:
    """Short text that changes with the files of a campaign and with its diagnosis."""
    parts = [(p.removeprefix(str(folder)), t, s) for p, t, s in stamp_of(folder)]
    with contextlib.suppress(OSError):
        stat = (folder / DIAGNOSIS).stat()
        parts.append((DIAGNOSIS, stat.st_mtime_ns, stat.st_size))
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()[:16]
