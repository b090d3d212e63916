# SPDX-License-Identifier: Apache-2.0
"""Identity of a run: hashes of its samples.

It does not depend on file name, folder, run record or file format. Two runs of a real machine
never have the same samples, so runs with the same samples are one run and its copy, or a
simulation without noise: neither says anything about scatter.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

from flatplank_data.checks import REQUIRED
from flatplank_data.problem import Problem
from flatplank_data.table import MeasurementTable

TOLD_BY = ("fx", "fy", "fz", "loaded_radius")
"""columns that differ with load, angles and pressure, even where no noise does"""


class Identity(NamedTuple):
    """Samples of a run."""

    needed: str
    """hash of the columns that runs of this kind have"""
    further: Mapping[str, str]
    """hashes of the others of `TOLD_BY`, which a copy may lack"""

    def same(self, other: Identity) -> bool:
        """Whether both are the samples of one run: all columns that both have are equal."""
        common = self.further.keys() & other.further.keys()
        return self.needed == other.needed and all(
            self.further[name] == other.further[name] for name in common
        )


class KnownRuns:
    """Files of runs by their samples."""

    def __init__(self) -> None:
        self._runs: dict[str, list[tuple[Identity, str]]] = {}

    def add(self, identity: Identity, file: str) -> str:
        """The file of the first run with these samples; the run is added."""
        found = self.find(identity)
        if found is None:
            self._runs.setdefault(identity.needed, []).append((identity, file))
        return found or file

    def find(self, identity: Identity) -> str | None:
        """The file of the first run with these samples."""
        runs = self._runs.get(identity.needed, [])
        return next((file for known, file in runs if known.same(identity)), None)


def identity_of(table: MeasurementTable) -> Identity:
    """Identity of a run, without its time, whose origin depends on the format.

    The samples are compared in single precision [SI], so that a change of units and back, or a
    file with 32-bit numbers, leaves the identity as it is. Raises FlatplankError when a column is
    missing.
    """
    needed = REQUIRED.get(table.info.measurement, ()) or sorted(table.columns)
    needed = [name for name in needed if name != "time"]
    further = (name for name in TOLD_BY if name not in needed and table.has(name))
    return Identity(_hash(table, needed), {name: _hash(table, [name]) for name in further})


def _hash(table: MeasurementTable, names: Iterable[str]) -> str:
    found = hashlib.sha256()
    for name in names:
        # adding zero makes +0 of -0
        values = table[name].astype("<f4") + np.float32(0.0)
        values[np.isnan(values)] = np.nan
        found.update(f"{name} {values.size}\n".encode())
        found.update(values.tobytes())
    return found.hexdigest()[:32]


def copy_of(table: MeasurementTable, known: KnownRuns) -> Problem | None:
    """The problem of a run with the same samples as an earlier one; None for a run of its own,
    which is added to the known ones."""
    file = table.info.file
    first = known.add(identity_of(table), file)
    if first == file:
        return None
    remedy = "a copy, or a simulation without noise, is no repeat: leave one of them out"
    return Problem(file, f"the same samples as {first}: not used", remedy=remedy)
