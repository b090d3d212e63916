# SPDX-License-Identifier: Apache-2.0
"""A table as data, with titled columns and one row per object; also as CSV."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

from flatplank_analysis.identify.results import Estimate
from flatplank_analysis.pages.csv_text import csv_text
from flatplank_data.condition import Condition

Cell = str | float
Column = tuple[str, Callable[[Any], Cell]]
"""title, and function from the row's object to its cell"""
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
        """The table as CSV, numbers with ten digits."""
        return csv_text([self.header, *self.rows])


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


def estimate(title: str, unit: str, name: str, factor: float = 1.0) -> list[Column]:
    """Columns of an estimate: value and standard error; NaN where it is not determined.

    name: attribute of the row's object, or attributes with dots between them.
    """
    of = attrgetter(name)
    return [
        (f"{title} [{unit}]", lambda row: factor * value_of(of(row))),
        (f"± [{unit}]", lambda row: factor * error_of(of(row))),
    ]


def value_of(e: Estimate) -> float:
    """The value, NaN where it is not determined."""
    return e.value if e.determined else math.nan


def error_of(e: Estimate) -> float:
    """The standard error, NaN where the value is not determined."""
    return e.std_error if e.determined else math.nan


def number(title: str, name: str, factor: float = 1.0) -> list[Column]:
    """Column of a plain number: the attribute `name` of the row's object times `factor`."""
    return [(title, lambda row: factor * getattr(row, name))]


def remark_of(*estimates: Estimate) -> str:
    """Reservations about these numbers; empty when there are none."""
    notes = []
    for e in estimates:
        if not e.determined:
            notes.append(e.note or "not determined")
        elif e.at_bound:
            notes.append(f"{e.name} at its {e.at_bound} bound")
        elif e.note:
            notes.append(e.note)
    return "; ".join(dict.fromkeys(notes))
