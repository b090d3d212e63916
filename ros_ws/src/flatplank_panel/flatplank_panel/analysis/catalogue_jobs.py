# SPDX-License-Identifier: Apache-2.0
"""The job of the page Catalogue: some of the runs that fulfil its conditions.

Nothing that takes long is imported, but to make a catalogue: the first answer waits for it.
"""

from __future__ import annotations

import os
import time
from datetime import datetime
from pathlib import Path
from typing import Any, NamedTuple

import pyarrow.compute as pc

from flatplank_analysis.catalogues.catalogue import Catalogue
from flatplank_analysis.catalogues.conditions import conditions_in
from flatplank_analysis.catalogues.kept import Update, file_of, stored
from flatplank_analysis.catalogues.shown import COLUMNS, problem_lines
from flatplank_data.errors import FlatplankError
from flatplank_data.progress import Progress

NEW = "this folder has no catalogue yet, it is made"
AGAIN = "looking for what changed"


class Held(NamedTuple):
    """A catalogue in memory, so that a question reads no file."""

    stamp: tuple[int, int] | None
    """time [ns] and size of its file; None without a file"""
    looked: float
    """time at which the folder was looked through [s]"""
    update: Update


HELD: dict[str, Held] = {}
"""root -> its catalogue; a panel has one root"""


def catalogue(
    progress: Progress,
    root: str,
    where: str = "",
    order: str = "",
    descending: bool = False,
    first: int = 0,
    count: int = 50,
    again: bool = False,
) -> dict[str, Any]:
    """Some of the runs that fulfil the conditions `where`, as texts, and how many there are.

    `order`: column to sort by; `first`, `count`: which of them; `again`: look for what changed. A
    root without a catalogue gets one.
    """
    if order and order not in COLUMNS:
        raise FlatplankError(f"no column '{order}'", "catalogue", "choose one of the table")
    conditions = conditions_in(where)
    held = held_catalogue(progress, root, again)
    whole = Catalogue(Path(root), held.update.table)
    rows = whole.where(**conditions).usable.table
    size = rows.num_rows
    if order:
        keys = [(order, "descending" if descending else "ascending")]
        rows = rows.take(pc.sort_indices(rows, sort_keys=keys))
    shown = rows.slice(first, count)
    texts = [COLUMNS[name].texts(shown[name]) for name in COLUMNS]
    unusable = whole.unusable.table
    return {
        "size": size, "of": pc.sum(pc.is_valid(whole.table["kind"])).as_py() or 0,
        "folders": len(held.update.stamps), "kept": held.update.kept,
        "looked": datetime.fromtimestamp(held.looked).strftime("%Y-%m-%d %H:%M"),
        "rows": [dict(zip(COLUMNS, row, strict=True)) for row in zip(*texts, strict=True)],
        "unusable": unusable.num_rows, "errors": problem_lines(unusable),
    }  # fmt: skip


def held_catalogue(progress: Progress, root: str, again: bool = False) -> Held:
    """The catalogue as it was kept; looked through `again`, or where there is none."""
    held = HELD.get(root)
    if held and not again and held.stamp == _stamp(root):
        return held
    found, stamp = None if again else stored(root), _stamp(root)
    looked = stamp[0] * 1e-9 if stamp else time.time()
    if found is None:
        from flatplank_analysis.catalogues.build import updated

        what = AGAIN if stamp else NEW
        progress(what, 0.0)
        found = updated(
            root,
            progress=lambda done, total, _name: progress(
                f"{what}: folder {done} of {total}", done / total
            ),
        )
        stamp, looked = _stamp(root), time.time()
    HELD[root] = Held(stamp, looked, found)
    return HELD[root]


def _stamp(root: str) -> tuple[int, int] | None:
    try:
        stat = os.stat(file_of(root))
    except OSError:
        return None
    return stat.st_mtime_ns, stat.st_size
