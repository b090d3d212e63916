# SPDX-License-Identifier: Apache-2.0
"""How numbers are written for people."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np


def with_unit(name: str, unit: str) -> str:
    """Label of an axis: the name, and the unit where there is one."""
    return name if unit in ("", "1", "-") else f"{name} [{unit}]"


def plain(value: float, digits: int = 3) -> str:
    """Significant digits; powers of ten only where a plain number would be hard to read."""
    if not 1e-4 <= abs(value) < 1e6:
        return f"{value:.{digits}g}"
    return np.format_float_positional(
        value, precision=digits, unique=False, fractional=False, trim="-"
    )


def brief(value: float, digits: int = 1) -> str:
    """So many digits behind the point; below one two that say something."""
    return f"{value:.{digits}f}" if abs(value) >= 1.0 or value == 0.0 else plain(value, 2)


SMALL = 0.1
"""lengths below are written in mm [m]"""


def displayed(unit: str, *values: float) -> tuple[float, str]:
    """Factor and unit in which people read such values: mm, deg; others as they are."""
    if unit == "m" and max(map(abs, values)) < SMALL:
        return 1e3, "mm"
    return (math.degrees(1.0), "deg") if unit == "rad" else (1.0, unit)


def quantity(value: float, unit: str, digits: int = 3) -> str:
    """A number [SI] with the unit in which people read it; one of unit "1" stands alone."""
    factor, name = displayed(unit, value)
    return plain(factor * value, digits) + ("" if name == "1" else f" {name}")


def span(low: float, high: float, unit: str, digits: int = 3) -> str:
    """'1.54 to 1.64 m'."""
    factor, name = displayed(unit, low, high)
    ends = (plain(factor * end, digits) for end in (low, high))
    return " to ".join(ends) + ("" if name == "1" else f" {name}")


def sized(value: float, interval: Sequence[float], unit: str, digits: int = 3) -> str:
    """A size with its 90 % interval: '0.742 mm (90 %: 0.672 to 0.813)'."""
    factor, name = displayed(unit, value)
    low, high = (plain(factor * end, digits) for end in interval)
    unit_word = "" if name == "1" else f" {name}"
    return f"{plain(factor * value, digits)}{unit_word} (90 %: {low} to {high})"


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
