# SPDX-License-Identifier: Apache-2.0
"""What a chapter is made of: entries, one for every figure and table, each with its rows.

A row is one number of the thesis, the place where it stands, and a function that measures ours.
Whether the two agree follows from the thesis's own stated accuracy, never from a sentence here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from flatplank_analysis.figures.spec import Figure
from flatplank_analysis.report.table import Table
from flatplank_data.errors import FlatplankError
from flatplank_validation.thesis.lab import Lab

Value = float | str
Draw = Callable[[Lab], Iterable[Figure]]
Tabulate = Callable[[Lab], Table]


class Rule(Protocol):
    """When a value of ours agrees with that of the thesis."""

    @property
    def text(self) -> str: ...

    def agrees(self, thesis: Value, ours: Value) -> bool: ...


class Near(NamedTuple):
    """Within a tolerance, in the unit of the row."""

    tolerance: float
    basis: str
    """where the thesis states this accuracy"""

    @property
    def text(self) -> str:
        return f"± {self.tolerance:.3g}: {self.basis}"

    def agrees(self, thesis: Value, ours: Value) -> bool:
        return abs(float(ours) - float(thesis)) <= self.tolerance


class AtMost(NamedTuple):
    """Not above a bound that the thesis states."""

    basis: str = "the thesis states a bound"

    @property
    def text(self) -> str:
        return f"at most: {self.basis}"

    def agrees(self, thesis: Value, ours: Value) -> bool:
        return float(ours) <= float(thesis)


class Same(NamedTuple):
    """The same finding, in words."""

    basis: str = "the same finding"

    @property
    def text(self) -> str:
        return self.basis

    def agrees(self, thesis: Value, ours: Value) -> bool:
        return thesis == ours


def printed(digit: float) -> Near:
    """Half of the last printed digit."""
    return Near(0.5 * digit, "half of the last printed digit")


@dataclass(frozen=True)
class Row:
    """One number of the thesis."""

    quantity: str
    unit: str
    thesis: Value
    place: str
    """where the number stands"""
    ours: Callable[[Lab], Value] | None
    """measures ours; None: nothing of ours shows it, and `why` says so"""
    rule: Rule
    why: str = ""
    """reason for a difference"""


AGREES, DIFFERS, UNSHOWN = "agrees", "differs", "cannot be shown"


class Finding(NamedTuple):
    """A row beside its measured value."""

    entry: str
    row: Row
    ours: Value | None
    verdict: str

    @property
    def identifier(self) -> str:
        return f"{self.entry}: {self.row.quantity}"

    @property
    def difference(self) -> float:
        """Ours less the thesis's; NaN for words."""
        values = (self.row.thesis, self.ours)
        if any(isinstance(v, str) or v is None for v in values):
            return math.nan
        return float(self.ours or 0.0) - float(self.row.thesis)

    @property
    def why(self) -> str:
        return "" if self.verdict == AGREES else self.row.why

    @property
    def unexplained(self) -> bool:
        return self.verdict != AGREES and not self.row.why


@dataclass(frozen=True)
class Entry:
    """A figure or table of the thesis."""

    number: str
    """as printed: 6.7, Table 7.1"""
    title: str
    draw: Draw | None = None
    rows: Sequence[Row] = ()
    table: Tabulate | None = None
    note: str = ""
    """what must be known to read it"""
    absent: str = ""
    """why it has no counterpart: a photograph, a block diagram"""


@dataclass(frozen=True)
class Chapter:
    """A chapter or an appendix."""

    key: str
    """as for --chapter"""
    title: str
    entries: Sequence[Entry]


def finding(entry: str, row: Row, lab: Lab) -> Finding:
    """Measure ours and compare."""
    if row.ours is None:
        return Finding(entry, row, None, UNSHOWN)
    try:
        ours = row.ours(lab)
    except FlatplankError as error:
        lab.say(f"{entry}, {row.quantity}: {error}")
        return Finding(entry, row, None, UNSHOWN)
    if isinstance(ours, float) and not math.isfinite(ours):
        return Finding(entry, row, ours, UNSHOWN)
    agrees = row.rule.agrees(row.thesis, ours)
    return Finding(entry, row, ours, AGREES if agrees else DIFFERS)
