# SPDX-License-Identifier: Apache-2.0
"""Identity of a run: the hash of its samples.

It does not depend on file name, folder, run record or file format. Two runs of a real machine
never have the same samples, so runs with the same identity are one run and its copy.
"""

from __future__ import annotations

import hashlib

import numpy as np

from flatplank_data.checks import REQUIRED
from flatplank_data.problem import Problem
from flatplank_data.table import MeasurementTable


def identifying_columns(measurement: str) -> tuple[str, ...]:
    """Columns that identify a run of this kind: those that it cannot do without, except the time,
    whose origin depends on the format. Empty for a kind without such columns: all columns."""
    return tuple(name for name in REQUIRED.get(measurement, ()) if name != "time")


def identity_of(table: MeasurementTable) -> str:
    """Hash (32 hexadecimal digits) of the samples of a run.

    The samples are compared in single precision [SI], so that a change of units and back, or a
    file with 32-bit numbers, leaves the identity as it is. Raises FlatplankError when a column is
    missing.
    """
    names = identifying_columns(table.info.measurement)
    names = names or tuple(sorted(set(table.columns) - {"time"}))
    found = hashlib.sha256()
    for name in names:
        # adding zero makes +0 of -0
        values = table[name].astype("<f4") + np.float32(0.0)
        values[np.isnan(values)] = np.nan
        found.update(f"{name} {values.size}\n".encode())
        found.update(values.tobytes())
    return found.hexdigest()[:32]


def copy_of(table: MeasurementTable, seen: dict[str, str]) -> Problem | None:
    """The problem of a run with the same samples as an earlier one; None for a run of its own.

    seen: identity -> file of the earlier runs; the run is added to it.
    """
    file = table.info.file
    first = seen.setdefault(identity_of(table), file)
    if first == file:
        return None
    remedy = "a copy is no repeat: leave one of them out"
    return Problem(file, f"the same samples as {first}: not used", remedy=remedy)
