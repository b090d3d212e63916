# SPDX-License-Identifier: Apache-2.0
"""Rows of a table or a figure as CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence


def csv_text(rows: Iterable[Sequence[str | float]]) -> str:
    """Rows as CSV, numbers with ten digits."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerows([f"{c:.10g}" if isinstance(c, float) else c for c in row] for row in rows)
    return stream.getvalue()
