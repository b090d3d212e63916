# SPDX-License-Identifier: Apache-2.0
"""Reads a file of sweeps: text, TYDEX or MATLAB."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from flatplank_analysis.slip_sweeps.channels import (
    BY_NAME,
    NOT_NEEDED,
    check_columns,
    check_values,
    columns_of,
    in_si,
    sizes,
)
from flatplank_analysis.slip_sweeps.raw import RAW, Raw
from flatplank_data.errors import FlatplankError
from flatplank_data.stamps import order_of

LEAST = 50
"""least number of samples of a sweep"""
FORCES = ("fx", "fy")
"""channels that only some of the conditions need"""


@dataclass(frozen=True)
class Recording:
    """Measured channels, in the axes of the file."""

    columns: Mapping[str, np.ndarray]
    """known channels by the names of `CHANNELS`, in SI; the others unchanged"""
    further: tuple[str, ...]
    """names of the other columns"""
    said: tuple[str, ...]
    """assumptions and omitted data, one line each"""


def read(path: str | Path, given: Mapping[str, str] | None = None) -> Recording:
    """Read a file of sweeps; given: channel -> column of the file, where it has another name.

    Raises:
        FlatplankError: the file cannot be used.
    """
    where = str(path)
    reader = RAW.get(Path(path).suffix.lower())
    if reader is None:
        raise FlatplankError("not a file of sweeps", where, f"give one of {', '.join(RAW)}")
    try:
        raw = reader(Path(path).read_bytes(), where)
    except OSError as error:
        raise FlatplankError(error.strerror or "cannot be read", where, "give a file") from None
    found = columns_of(list(raw.columns), given or {}, where)
    said = list(raw.said)
    found, lost = _measured(raw, found)
    check_columns(list(found), where)
    columns, remarks = _in_si(raw, found, where)
    further = {k: v for k, v in raw.columns.items() if k not in found.values()}
    rows, told = _rows(raw, found, columns, where)
    kept = {k: v[rows] for k, v in {**columns, **further}.items()}
    return Recording(kept, tuple(further), (*said, *lost, *remarks, *told))


def _measured(raw: Raw, found: Mapping[str, str]) -> tuple[dict[str, str], list[str]]:
    """Channels with at least one number, and remarks on the others."""
    kept, said = {}, []
    for name, theirs in found.items():
        if np.isfinite(raw.columns[theirs]).any():
            kept[name] = theirs
        else:
            said.append(f"column '{theirs}' has no number and was not measured")
    return kept, said


def _in_si(
    raw: Raw, found: Mapping[str, str], where: str
) -> tuple[dict[str, np.ndarray], list[str]]:
    """Channels in SI, without those not needed whose unit is not known; and the assumptions."""
    values = {name: raw.columns[theirs] for name, theirs in found.items()}
    size, columns, said, assumed = sizes(values), {}, [], []
    for name, theirs in found.items():
        place, unit = f"{where}, '{theirs}'", raw.units.get(theirs)
        try:
            columns[name], guess = in_si(BY_NAME[name], values[name], unit, size[name], place)
        except FlatplankError as error:
            if name not in NOT_NEEDED:
                raise
            said.append(f"column '{theirs}' was left out: {error.what}")
            continue
        most = float(np.nanmax(np.abs(values[name])))
        assumed += [f"{name} in {guess} (up to {most:.3g})"] if guess else []
    if assumed:
        said.append(f"no unit in the file, taken to be: {', '.join(assumed)}")
    check_values(columns, found, where)
    return columns, said


def _rows(
    raw: Raw, found: Mapping[str, str], columns: Mapping[str, np.ndarray], where: str
) -> tuple[np.ndarray, list[str]]:
    """Rows with all numbers that each condition needs, in order of time; what was left out."""
    said = []
    whole = np.ones(len(columns["fz"]), dtype=bool)
    for name, values in columns.items():
        gaps = ~np.isfinite(values)
        if not gaps.any() or name in NOT_NEEDED:
            continue
        count = f"{int(gaps.sum())} of {len(gaps)} samples"
        place = f"no number in '{found[name]}', first {raw.first(found[name], gaps)}"
        if name in FORCES:
            said.append(f"{count} have no {name.capitalize()}: {place}")
            continue
        said.append(f"{count} are left out: {place}")
        whole &= ~gaps
    if whole.sum() < LEAST:
        reason = f" ({'; '.join(said)})" if said else ""
        raise FlatplankError(
            f"{int(whole.sum())} whole samples{reason}", where, f"a sweep needs {LEAST} at least"
        )
    rows = np.flatnonzero(whole)
    order, told = _order(columns.get("time"), rows, where)
    return order, said + told


def _order(
    stamps: np.ndarray | None, rows: np.ndarray, where: str
) -> tuple[np.ndarray, list[str]]:
    """The rows in order of time, where the file has stamps."""
    if stamps is None or not np.isfinite(stamps[rows]).all():
        return rows, []
    order = order_of(stamps[rows], LEAST)
    if order.rows is not None:
        return rows[order.rows], ["rows are not in order of time: sorted by their stamps"]
    if order.recordings * LEAST > len(rows):
        row = order.back - 1
        raise FlatplankError(
            f"time does not increase: {stamps[rows[row]]:g} s after {stamps[rows[row - 1]]:g} s",
            f"{where}, sample {rows[row] + 1}", "sort the rows by time",
        )  # fmt: skip
    if order.recordings > 1:
        return rows, [f"{order.recordings} recordings follow one another: the time starts again"]
    return rows, []
