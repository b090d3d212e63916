# SPDX-License-Identifier: Apache-2.0
"""Runs that two sets have in common, where the sets must be disjoint."""

from __future__ import annotations

from collections.abc import Iterable

from flatplank_data.campaign import Run
from flatplank_data.errors import FlatplankError
from flatplank_data.identity import Identity, KnownRuns


def shared_runs(one: Iterable[Run], other: Iterable[Run]) -> list[tuple[str, str]]:
    """Files of runs of `one` that are in `other`, too, each with the file there.

    A run is known by its uuid and by its samples: not by folder, file name, record or format.
    """
    by_uuid, by_samples = {}, KnownRuns()
    for run in other:
        if run.info.uuid:
            by_uuid[run.info.uuid] = run.info.file
        identity = _identity(run)
        if identity:
            by_samples.add(identity, run.info.file)
    found = []
    for run in one:
        identity = _identity(run)
        same = by_uuid.get(run.info.uuid) or (identity and by_samples.find(identity))
        if same:
            found.append((run.info.file, same))
    return found


def _identity(run: Run) -> Identity | None:
    try:
        return run.identity()
    except FlatplankError:  # not usable: no set has its samples
        return None
