# SPDX-License-Identifier: Apache-2.0
"""The columns of a catalogue as people read them: titles with units, values in mm, %, N, bar."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import pyarrow as pa

NOTHING = "-"
"""what stands for a value that is not stated"""
SHOWN = 40
"""rows that are shown of a list without pages"""
DAY = len("2026-05-01")
"""characters of a date that are shown"""


@dataclass(frozen=True)
class Column:
    """A column of `kept.SCHEMA` as it is shown."""

    title: str
    unit: str = ""
    factor: float = 1.0
    """from the unit of the catalogue to the one that is shown"""
    most: int | None = None
    """characters that are shown; None: all"""

    @property
    def head(self) -> str:
        """Title with the unit."""
        return f"{self.title} [{self.unit}]" if self.unit else self.title

    def texts(self, values: pa.ChunkedArray) -> list[str]:
        """The values of rows as texts, in the unit that is shown."""
        return [self._text(value) for value in values.to_pylist()]

    def _text(self, value: Any) -> str:
        if value is None or value == "":
            return NOTHING
        if isinstance(value, float):
            return f"{self.factor * value:.6g}"
        return str(value)[: self.most]


COLUMNS: Mapping[str, Column] = {
    "folder": Column("folder"), "file": Column("run"), "tire": Column("tire"),
    "fz": Column("load", "N"), "pressure": Column("pressure", "bar"),
    "kappa": Column("slip", "%", 100.0), "alpha_deg": Column("side slip", "deg"),
    "gamma_deg": Column("camber", "deg"), "date": Column("date", most=DAY),
    "bench": Column("bench"), "quality": Column("quality"), "verdict": Column("verdict"),
    "effects": Column("effects"), "kind": Column("kind"), "serial": Column("serial"),
    "effective_rolling_radius": Column("rolling radius", "mm", 1e3),
    "speed": Column("speed", "mm/s", 1e3),
    "start": Column("start"), "repeat": Column("repeat"), "operator": Column("operator"),
    "status": Column("status"), "cycles_lost": Column("cycles lost"), "notes": Column("notes"),
}  # fmt: skip
"""column of the catalogue -> how it is shown"""


def problem_lines(unusable: pa.Table) -> list[str]:
    """Why files cannot be used, a line each, of `SHOWN` at most, and how many more there are."""
    lines = [f"{row['folder']}: {row['error']}" for row in unusable.slice(0, SHOWN).to_pylist()]
    more = unusable.num_rows - SHOWN
    return lines + ([f"and {more} more"] if more > 0 else [])
