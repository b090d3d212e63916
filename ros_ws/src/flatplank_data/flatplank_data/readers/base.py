# SPDX-License-Identifier: Apache-2.0
"""One reader per file format, found by suffix; and the mapping of foreign columns, of their names
and of those with the opposite sign."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from flatplank_data.errors import FlatplankError
from flatplank_data.names import similar_names
from flatplank_data.run_record import KNOWN_SUFFIXES, RunRecord
from flatplank_data.store import Store
from flatplank_data.table import COLUMN_UNITS
from flatplank_data.units import to_si
from flatplank_tire.numbers import NotNumbers


@dataclass(frozen=True)
class Loaded:
    """What a reader found in a file: columns in SI, facts of the run record, remarks."""

    columns: Mapping[str, np.ndarray]
    facts: Mapping[str, Any] = field(default_factory=dict)
    remarks: Sequence[str] = ()


@dataclass(frozen=True)
class Request:
    """A file, and the columns that a reader is to take from it."""

    store: Store
    name: str
    columns: Sequence[str] | None = None
    """wanted columns; None for all"""
    mapping: Mapping[str, Any] | None = None
    """foreign names, as in a mapping file"""
    further: bool = False
    """also read numeric columns with unknown names, unconverted; see `column_of`"""
    needed: Collection[str] = ()
    """columns in which each cell must be a number"""

    def wants(self, column: str) -> bool:
        """True when `column` was asked for."""
        if self.columns is None or column in self.columns:
            return True
        return self.further and column not in COLUMN_UNITS


Reader = Callable[[Request], Loaded]
_READERS: dict[str, Reader] = {}


def reader(*suffixes: str) -> Callable[[Reader], Reader]:
    """Register a reader for file suffixes, entries of `KNOWN_SUFFIXES`."""

    def register(function: Reader) -> Reader:
        for suffix in suffixes:
            if suffix not in KNOWN_SUFFIXES:
                raise ValueError(f"'{suffix}' is missing in KNOWN_SUFFIXES of run_record.py")
            _READERS[suffix] = function
        return function

    return register


Describer = Callable[[Store, str], Mapping[str, Any]]
_DESCRIBERS: dict[str, Describer] = {}


def describer(*suffixes: str) -> Callable[[Describer], Describer]:
    """Register a function that reads the run record of a file without its samples."""

    def register(function: Describer) -> Describer:
        for suffix in suffixes:
            _DESCRIBERS[suffix] = function
        return function

    return register


def read_description(store: Store, name: str) -> Mapping[str, Any]:
    """Facts of the run record that can be read without the samples; empty if none."""
    function = _DESCRIBERS.get(_suffix(store, name))
    return function(store, name) if function else {}


def suffixes() -> list[str]:
    """Suffixes that can be read."""
    return sorted(_READERS)


def reader_for(store: Store, name: str) -> Reader:
    """The reader of a file; a folder is read as a bag. Raises FlatplankError without a reader."""
    suffix = _suffix(store, name)
    try:
        return _READERS[suffix]
    except KeyError:
        raise FlatplankError(
            f"no reader for '{suffix or name}'", name, f"use one of {', '.join(suffixes())}"
        ) from None


def _suffix(store: Store, name: str) -> str:
    suffix = "." + name.rsplit(".", 1)[-1].lower() if "." in name else ""
    return ".mcap" if suffix not in _READERS and store.is_dir(name) else suffix


def column_of(
    values: np.ndarray, unit: str | None, name: str, where: str
) -> tuple[str, np.ndarray]:
    """Name and values of a column in SI. An unknown column keeps its unit, in brackets in the
    name."""
    if name in COLUMN_UNITS:
        known = COLUMN_UNITS[name]
        return name, to_si(values, known if unit is None else unit, known, where)
    return (f"{name} [{unit}]" if unit and not name.endswith("]") else name), values


def columns_in_si(
    names: Mapping[str, str],
    request: Request,
    values_of: Callable[[str], np.ndarray],
    unit_of: Callable[[str], str | None],
    kind: str = "column",
) -> dict[str, np.ndarray]:
    """The wanted columns by name, in SI; `names`: file column -> our column. No unit means SI."""
    columns = {}
    for theirs, ours in names.items():
        if request.wants(ours):
            where = f"{request.name}, {kind} '{theirs}'"
            name, values = column_of(values_of(theirs), unit_of(theirs), ours, where)
            columns[name] = values
    return columns


def left_out(request: Request, theirs: str, ours: str, cells: NotNumbers) -> str:
    """Remark on cells that are no numbers; FlatplankError in a column that the run needs."""
    if ours in request.needed:
        text, _, line = cells.first.rpartition(" in ")
        raise FlatplankError(
            f"{text} in column '{theirs}' is not a number", f"{request.name}, {line}",
            "correct or remove the line",
        )  # fmt: skip
    return f"column '{theirs}': {cells}"


def known_name(name: str, mapping: Mapping[str, Any] | None) -> str:
    """Our name of a column of a file; the name itself where it is not known."""
    foreign = (mapping or {}).get("columns") or {}
    return str(foreign.get(name) or _PLAIN.get(_plain(name), name))


def _plain(name: str) -> str:
    return re.sub(r"[\W_]+", "", name).lower()


_PLAIN = {_plain(name): name for name in COLUMN_UNITS}


def canonical_names(
    names: Iterable[str], mapping: Mapping[str, Any] | None, further: bool = False
) -> tuple[dict[str, str], list[str]]:
    """File column -> our column, and remarks on columns that are not known.

    The mapping file may have `columns: {theirs: ours}`; in other names case, blanks and hyphens do
    not count. further: unknown columns are kept under their own names. FlatplankError for two
    columns that are the same one.
    """
    out: dict[str, str] = {}
    remarks: list[str] = []
    for name in names:
        ours = known_name(name, mapping)
        if ours in COLUMN_UNITS:
            twice = next((n for n, o in out.items() if o == ours), None)
            if twice is not None:
                what = f"columns '{twice}' and '{name}' are both '{ours}'"
                raise FlatplankError(what, "header", "rename or remove one")
            out[name] = ours
            continue
        near = similar_names(ours.lower(), COLUMN_UNITS, 0.6)
        hint = f" (nearest: '{near[0]}')" if near else ""
        if further:
            out[name] = ours
            remarks += [f"column '{name}' is kept as a further coordinate{hint}"] if hint else []
            continue
        remarks.append(f"column '{name}' is not known and was left out{hint}")
    return out, remarks


SIGNED = ("kappa", "alpha_deg", "gamma_deg")
"""keys of a run record that have a sign"""


def turned_names(mapping: Mapping[str, Any] | None) -> tuple[str, ...]:
    """Columns and keys of the run record with the opposite sign in foreign files: `mapping: {turn:
    [fy, alpha_deg]}`. FlatplankError for an unknown name."""
    names = (mapping or {}).get("turn") or ()
    names = (names,) if isinstance(names, str) else tuple(str(n) for n in names)
    for name in names:
        if name not in SIGNED and name not in COLUMN_UNITS:
            known = ", ".join([*SIGNED, *COLUMN_UNITS])
            raise FlatplankError(f"no column or key '{name}'", "mapping, turn", f"known: {known}")
    return names


def turned_columns(
    columns: Mapping[str, np.ndarray], mapping: Mapping[str, Any] | None
) -> dict[str, np.ndarray]:
    """The columns, with the signs that the mapping turns."""
    names = turned_names(mapping)
    return {k: -v if k in names else v for k, v in columns.items()}


def turned_facts(facts: Mapping[str, Any], mapping: Mapping[str, Any] | None) -> dict[str, Any]:
    """The facts of a run, with the signs that the mapping turns."""
    names = [n for n in turned_names(mapping) if n in SIGNED and facts.get(n)]
    return {**facts, **{n: -float(facts[n]) for n in names}}


def turned_info(info: RunRecord, mapping: Mapping[str, Any] | None) -> RunRecord:
    """The run record, with the signs that the mapping turns."""
    names = [n for n in turned_names(mapping) if n in SIGNED and getattr(info, n)]
    return dataclasses.replace(info, **{n: -getattr(info, n) for n in names})
