# SPDX-License-Identifier: Apache-2.0
"""Runs that two sets have in common, where the sets must be disjoint."""

from __future__ import annotations

from collections.abc import Iterable

from flatplank_data.campaign import Run
from flatplank_data.errors import FlatplankError


def shared_runs(one: Iterable[Run], other: Iterable[Run]) -> list[tuple[str, str]]:
    """Files of runs of `one` that are in `other`, too, each with the file there.

    A run is known by its uuid and by its samples: not by folder, file name, record or format.
    """
    known = {mark: run.info.file for run in other for mark in _marks(run)}
    found = []
    for run in one:
        same = next((known[mark] for mark in _marks(run) if mark in known), None)
        if same is not None:
            found.append((run.info.file, same))
    return found


def _marks(run: Run) -> list[str]:
    marks = [f"uuid {run.info.uuid}"] if run.info.uuid else []
    try:
        return [*marks, f"samples {run.identity()}"]
    except FlatplankError:  # not usable: no set has its samples
        return marks
