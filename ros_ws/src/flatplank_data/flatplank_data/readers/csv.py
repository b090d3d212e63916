# SPDX-License-Identifier: Apache-2.0
"""Reads text tables: units as `fx [N]` or in a second line; without units SI."""

from __future__ import annotations

import numpy as np

from flatplank_data.delimited import TextTable, read_text_table
from flatplank_data.errors import FlatplankError
from flatplank_data.readers.base import (
    Loaded,
    Request,
    canonical_names,
    columns_in_si,
    known_name,
    left_out,
    reader,
)
from flatplank_data.table import COLUMN_UNITS


@reader(".csv")
def read_csv(request: Request) -> Loaded:
    """Read a table; lines that start with '#' before the names are comments."""
    with request.store.open(request.name) as stream:
        table = read_text_table(
            stream.read(), request.name, lambda n: known_name(n, request.mapping) in COLUMN_UNITS
        )
    names, remarks = canonical_names(table.names, request.mapping, request.further)
    columns: dict[str, np.ndarray] = {}
    for name, ours in list(names.items()):
        if not request.wants(ours):
            continue
        if ours == "time":
            try:
                columns[name] = table.time(name)
            except FlatplankError as error:
                if ours in request.needed:
                    raise
                del names[name]
                remarks.append(f"column '{name}' was left out: {error.what}")
            continue
        columns[name], other = table.column(name)
        if ours not in COLUMN_UNITS and other.all():
            del names[name]
            remarks.append(f"column '{name}' is text and was left out")
        elif other.any():
            remarks.append(left_out(request, name, ours, table.not_numbers(name, other)))
    _check_units(table, names, request)
    read = columns_in_si(names, request, columns.__getitem__, table.units.get)
    return Loaded(read, {}, [*table.remarks, *remarks])


def _check_units(table: TextTable, names: dict[str, str], request: Request) -> None:
    """Check that all known columns have a unit, or none (then the file is in SI)."""
    known = [n for n, ours in names.items() if COLUMN_UNITS.get(ours, "1") != "1"]
    missing = [n for n in known if n not in table.units]
    if missing and len(missing) < len(known):
        raise FlatplankError(
            f"column '{missing[0]}' has no unit while others have one",
            f"{request.name}, header",
            f"write it as '{missing[0]} [unit]', or give no unit at all for a file in SI",
        )
