# SPDX-License-Identifier: Apache-2.0
"""What runs can be selected by: tire, load, pressure, date, bench, quality and others."""

from __future__ import annotations

import re
import shlex
import struct
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from datetime import date, datetime, timedelta
from typing import Any

import pyarrow as pa
import pyarrow.compute as pc

from flatplank_data.errors import FlatplankError
from flatplank_data.names import nearest_hint
from flatplank_data.units import factor_offset

NOMINAL = 0.02
"""a value within this share of a wanted one is that level: some records have measured values"""
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_QUANTITY = re.compile(rf"({_NUMBER})(?:\s*\.\.\s*({_NUMBER}))?\s*(.*)")

Keep = Callable[[pa.Table], pa.ChunkedArray]
"""rows -> True for those that are wanted"""


def constant(value: str | float) -> pa.Scalar:
    """A number or text to compare with, made of its bytes: `pa.scalar` brings pandas with it,
    which takes a second."""
    if isinstance(value, float):
        kind, parts = pa.float64(), [struct.pack("=d", value)]
    else:
        said = value.encode()
        kind, parts = pa.string(), [struct.pack("=ii", 0, len(said)), said]
    return pa.Array.from_buffers(kind, 1, [None, *map(pa.py_buffer, parts)])[0]


def _equals(own: pa.ChunkedArray, text: str) -> pa.ChunkedArray:
    return pc.equal(own, constant(text))


@dataclass(frozen=True)
class Text:
    """A text, whatever its case: the whole one, or as `compare` says."""

    column: str
    compare: Callable[[pa.ChunkedArray, str], pa.ChunkedArray] = _equals

    def keep(self, wanted: Any, _where: str) -> Keep:
        text = str(wanted).lower()
        return lambda rows: self.compare(pc.utf8_lower(_texts(rows, self.column)), text)


def _texts(rows: pa.Table, column: str) -> pa.ChunkedArray:
    return pc.coalesce(rows[column], constant(""))


@dataclass(frozen=True)
class Number:
    """A level or a range, as 2.5, `2.5bar`, `36psi` or `2..3bar`; without a unit in `unit`."""

    column: str
    unit: str
    si: str

    def keep(self, wanted: Any, where: str) -> Keep:
        found = _QUANTITY.fullmatch(str(wanted).strip())
        if not found:
            what = f"'{wanted}' is no number of {self.unit}"
            raise FlatplankError(what, where, f"write 2.5 or 2..3, in {self.unit}")
        low, high = (self._own(n, found[3], where) for n in (found[1], found[2] or found[1]))
        slack = 0.0 if found[2] else NOMINAL * abs(low)
        return lambda rows: pc.and_(
            pc.greater_equal(rows[self.column], constant(low - slack)),
            pc.less_equal(rows[self.column], constant(high + slack)),
        )

    def _own(self, number: str, unit: str, where: str) -> float:
        """A number in the unit of the column."""
        factor, offset = factor_offset(unit or self.unit, self.si, where)
        per, _ = factor_offset(_OF_COLUMN.get(self.column, self.si), self.si, where)
        return (float(number) * factor + offset) / per


_OF_COLUMN = {"pressure": "bar", "alpha_deg": "deg", "gamma_deg": "deg"}
"""units of columns that are not in SI"""


@dataclass(frozen=True)
class Day:
    """A date, the first day or the last day that is wanted; runs without a date are left out."""

    first: bool = False
    last: bool = False
    column: str = "date"

    def keep(self, wanted: Any, where: str) -> Keep:
        try:
            day = date.fromisoformat(str(wanted)[:10])
        except ValueError:
            what = f"'{wanted}' is no date"
            raise FlatplankError(what, where, "write it as 2026-05-01") from None
        low = "" if self.last else day.isoformat()
        high = "9" if self.first else (day + timedelta(days=1)).isoformat()

        def kept(rows: pa.Table) -> pa.ChunkedArray:
            own = _texts(rows, self.column)
            stated = pc.not_equal(own, constant(""))
            since = pc.and_(stated, pc.greater_equal(own, constant(low)))
            return pc.and_(since, pc.less(own, constant(high)))

        return kept


CONDITIONS: Mapping[str, Text | Number | Day] = {
    "tire": Text("tire"),
    "serial": Text("serial"),
    "load": Number("fz", "N", "N"),
    "pressure": Number("pressure", "bar", "Pa"),
    "slip": Number("kappa", "%", "1"),
    "alpha": Number("alpha_deg", "deg", "rad"),
    "camber": Number("gamma_deg", "deg", "rad"),
    "kind": Text("kind"),
    "date": Day(),
    "since": Day(first=True),
    "until": Day(last=True),
    "bench": Text("bench"),
    "operator": Text("operator"),
    "status": Text("status"),
    "quality": Text("quality", pc.starts_with),
    "verdict": Text("verdict"),
    "effect": Text("effects", pc.match_substring),
    "folder": Text("folder", pc.starts_with),
}
"""name of a condition -> what it compares"""


def conditions_in(line: str) -> dict[str, str]:
    """The conditions of a line as a shell reads it: `tire=TOY bench='hall 2'`.

    Raises FlatplankError for a quote without its end, and as `conditions_of`.
    """
    try:
        words = shlex.split(line)
    except ValueError:
        raise FlatplankError("a quote has no end", "where", "write bench='hall 2'") from None
    return conditions_of(words)


def conditions_of(words: Iterable[str]) -> dict[str, str]:
    """Conditions that are written as KEY=VALUE.

    Raises FlatplankError for a word of another form, and for a key that is there twice.
    """
    found: dict[str, str] = {}
    for word in words:
        name, mark, value = word.partition("=")
        if not mark or not value:
            raise FlatplankError(f"'{word}' is not KEY=VALUE", "where", "write tire=TOY")
        if name in found:
            what = f"'{name}' is there twice"
            raise FlatplankError(what, "where", "write a range as load=3000..4000")
        found[name] = value
    return found


def keeps(name: str, wanted: Any) -> Keep:
    """The selection of one condition; FlatplankError for an unknown name or a wrong value."""
    if name not in CONDITIONS:
        what = f"no condition '{name}'{nearest_hint(name, CONDITIONS)}"
        raise FlatplankError(what, "where", "write KEY=VALUE, as tire=TOY")
    if isinstance(wanted, (date, datetime)):
        wanted = wanted.isoformat()
    return CONDITIONS[name].keep(wanted, f"where, {name}")
