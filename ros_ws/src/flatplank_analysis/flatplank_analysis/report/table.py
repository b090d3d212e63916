# SPDX-License-Identifier: Apache-2.0
"""A table as data: columns by title, rows by what they are about."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from flatplank_data.condition import Condition

Cell = str | float
Column = tuple[str, Callable[[Any], Cell]]
"""title, and what a row's object has there"""
POINT_COLUMNS = ("Fz [N]", "p [bar]", "α [°]", "γ [°]")


@dataclass(frozen=True)
class Table:
    """Rows of texts and numbers under a header."""

    name: str
    title: str
    header: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    note: str = ""

    def csv(self) -> str:
        """All digits."""
        stream = io.StringIO()
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(self.header)
        for row in self.rows:
            writer.writerow([f"{c:.10g}" if isinstance(c, float) else c for c in row])
        return stream.getvalue()


def point_cells(point: Condition) -> list[Cell]:
    """The operating point as the first cells of a row."""
    values = (point.fz, point.pressure, point.alpha_deg, point.gamma_deg)
    return [f"{v:.10g}" for v in values]


def point_table(
    name: str,
    title: str,
    rows: Iterable[tuple[Condition, Any]],
    columns: Sequence[Column],
    note: str,
) -> Table:
    """One row per operating point or condition and the object that belongs to it."""
    header = (*POINT_COLUMNS, *(text for text, _ in columns))
    cells = [[*point_cells(point), *(read(it) for _, read in columns)] for point, it in rows]
    return Table(name, title, header, cells, note)
