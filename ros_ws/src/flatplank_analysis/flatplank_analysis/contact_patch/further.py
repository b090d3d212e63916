# SPDX-License-Identifier: Apache-2.0
"""What was recorded or set beside the channels of the search: further columns of the tables by
their own names, and settings that differ from run to run. Any of it may be a cause."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from flatplank_analysis.discovery.runs import Coordinate
from flatplank_data.errors import FlatplankError
from flatplank_data.table import COLUMN_UNITS, MeasurementTable

if TYPE_CHECKING:
    from flatplank_analysis.contact_patch.data import TireRuns

SIGNALS = {"fy": "N", "mx": "N m", "mz": "N m"}
"""channels that are coordinates as well: one may speak over into another"""
SETTINGS = {"pressure": "bar", "alpha": "rad", "gamma": "rad", "speed": "m/s"}
"""facts of a run that are coordinates where they differ between runs"""
_BRACKETS = re.compile(r"^(.*?)\s*[\[(]([^\])]*)[\])]$")


def further_columns(
    tables: Sequence[MeasurementTable], times: Sequence[np.ndarray]
) -> dict[str, Coordinate]:
    """Further columns that all runs have, at the times of their nodes [s]."""
    names = [n for n in tables[0].columns if n not in COLUMN_UNITS]
    out = {}
    for column in names:
        if all(t.has(column) for t in tables):
            match = _BRACKETS.match(column.strip())
            name, unit = (match[1], match[2]) if match else (column.strip(), "1")
            rows = [_at(t["time"], t[column], at) for t, at in zip(tables, times, strict=True)]
            out[name] = Coordinate(np.stack(rows), unit or "1", 27)
    return out


def _at(time: np.ndarray, values: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    good = np.isfinite(values) & np.isfinite(time)
    return np.interp(nodes, time[good], values[good])


def coordinates_of(data: TireRuns) -> Mapping[str, Coordinate]:
    """Everything by name in which something may show itself; further columns go first."""
    shape = data.position.shape
    out = dict(data.runs.coordinates)
    for name, unit in SIGNALS.items():
        if name in data.signals:
            out[name] = Coordinate(data.signals[name], unit, 24)
    for name, unit in SETTINGS.items():
        values = np.broadcast_to(data.runs.facts[name][:, None], shape)
        out[name] = Coordinate(values, unit, 9)
    return out | dict(data.further)


def coordinate_of(data: TireRuns, name: str) -> Coordinate:
    """One of them; FlatplankError when the runs do not have it."""
    known = coordinates_of(data)
    if name not in known:
        raise FlatplankError(
            f"the runs have no '{name}'", "coordinate",
            f"record it as a column '{name} [unit]' of every run",
        )  # fmt: skip
    return known[name]
