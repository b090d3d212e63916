# SPDX-License-Identifier: Apache-2.0
"""What runs can be selected by: tire, load, pressure, date, bench, quality and others."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import date, datetime, timedelta
from typing import Any

import pandas as pd

from flatplank_data.errors import FlatplankError
from flatplank_data.names import nearest_hint
from flatplank_data.units import factor_offset

NOMINAL = 0.02
"""a value within this share of a wanted one is that level: some records have measured values"""
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_QUANTITY = re.compile(rf"({_NUMBER})(?:\s*\.\.\s*({_NUMBER}))?\s*(.*)")

Keep = Callable[[pd.DataFrame], pd.Series]
"""rows -> True for those that are wanted"""


@dataclass(frozen=True)
class Text:
    """A text, whatever its case: the whole one, or as `compare` says."""

    column: str
    compare: Callable[[pd.Series, str], pd.Series] = pd.Series.eq

    def keep(self, wanted: Any, _where: str) -> Keep:
        text = str(wanted).casefold()

        def kept(rows: pd.DataFrame) -> pd.Series:
            own = rows[self.column].fillna("").str.casefold()
            return self.compare(own, text)

        return kept


def _begins(own: pd.Series, text: str) -> pd.Series:
    return own.str.startswith(text)


def _contains(own: pd.Series, text: str) -> pd.Series:
    return own.str.contains(text, regex=False)


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
        return lambda rows: rows[self.column].between(low - slack, high + slack)

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

    def keep(self, wanted: Any, where: str) -> Keep:
        try:
            day = date.fromisoformat(str(wanted)[:10])
        except ValueError:
            what = f"'{wanted}' is no date"
            raise FlatplankError(what, where, "write it as 2026-05-01") from None
        low = "" if self.last else day.isoformat()
        high = "9" if self.first else (day + timedelta(days=1)).isoformat()
        return lambda rows: _dates(rows).between(low, high, inclusive="left") & _dates(rows).ne("")


def _dates(rows: pd.DataFrame) -> pd.Series:
    return rows["date"].fillna("")


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
    "quality": Text("quality", _begins),
    "verdict": Text("verdict"),
    "effect": Text("effects", _contains),
    "folder": Text("folder", _begins),
}
"""name of a condition -> what it compares"""


def keeps(name: str, wanted: Any) -> Keep:
    """The selection of one condition; FlatplankError for an unknown name or a wrong value."""
    if name not in CONDITIONS:
        what = f"no condition '{name}'{nearest_hint(name, CONDITIONS)}"
        raise FlatplankError(what, "where", "write KEY=VALUE, as tire=TOY")
    if isinstance(wanted, (date, datetime)):
        wanted = wanted.isoformat()
    return CONDITIONS[name].keep(wanted, f"where, {name}")
