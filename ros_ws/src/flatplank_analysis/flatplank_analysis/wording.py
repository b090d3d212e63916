# SPDX-License-Identifier: Apache-2.0
"""How numbers are written for people."""

from __future__ import annotations

import numpy as np


def plain(value: float, digits: int = 3) -> str:
    """Significant digits; powers of ten only where a plain number would be hard to read."""
    if not 1e-4 <= abs(value) < 1e6:
        return f"{value:.{digits}g}"
    return np.format_float_positional(
        value, precision=digits, unique=False, fractional=False, trim="-"
    )


def quantity(value: float, unit: str, digits: int = 3) -> str:
    """A number with its unit; what has none (unit "1") stands alone."""
    return plain(value, digits) + ("" if unit == "1" else f" {unit}")


def table(rows: list[tuple[str, ...]]) -> str:
    """Text columns, the first to the left, the others to the right."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    out = []
    for row in rows:
        cells = [
            cell.ljust(w) if i == 0 else cell.rjust(w)
            for i, (cell, w) in enumerate(zip(row, widths, strict=True))
        ]
        out.append("  ".join(cells).rstrip())
    return "\n".join(out)
