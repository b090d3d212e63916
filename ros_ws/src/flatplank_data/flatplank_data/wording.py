# SPDX-License-Identifier: Apache-2.0
"""Formats numbers for people."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np


def with_unit(name: str, unit: str) -> str:
    """Axis label: the name, with the unit where there is one."""
    return name if unit in ("", "1", "-") else f"{name} [{unit}]"


def six_digits(value: float) -> float | None:
    """A number rounded for programs; None when it is not finite."""
    return float(f"{value:.6g}") if np.isfinite(value) else None


def plain(value: float, digits: int = 3) -> str:
    """The number with significant digits; powers of ten only for very large or small ones."""
    if not 1e-4 <= abs(value) < 1e6:
        return f"{value:.{digits}g}"
    return np.format_float_positional(
        value, precision=digits, unique=False, fractional=False, trim="-"
    )


def brief(value: float, digits: int = 1) -> str:
    """The number with `digits` decimals; below 1 with two significant digits."""
    return f"{value:.{digits}f}" if abs(value) >= 1.0 or value == 0.0 else plain(value, 2)


SMALL = 0.1
"""lengths below this are written in mm [m]"""


def displayed(unit: str, *values: float) -> tuple[float, str]:
    """Factor and display unit: mm for small lengths, deg for rad; other units unchanged."""
    if unit == "m" and max(map(abs, values)) < SMALL:
        return 1e3, "mm"
    return (math.degrees(1.0), "deg") if unit == "rad" else (1.0, unit)


def quantity(value: float, unit: str, digits: int = 3, axis: Sequence[float] = ()) -> str:
    """A number [SI] in its display unit, or in that of the axis whose ends are given; without a
    unit when `unit` is "1"."""
    factor, name = displayed(unit, *(axis or (value,)))
    return plain(factor * value, digits) + ("" if name == "1" else f" {name}")


def span(low: float, high: float, unit: str, digits: int = 3, axis: Sequence[float] = ()) -> str:
    """A range in its display unit, or in that of the axis whose ends are given: '1.54 to 1.64
    m'."""
    factor, name = displayed(unit, *(axis or (low, high)))
    ends = (plain(factor * end, digits) for end in (low, high))
    return " to ".join(ends) + ("" if name == "1" else f" {name}")


def sized(value: float, interval: Sequence[float], unit: str, digits: int = 3) -> str:
    """A value with its 90 % interval: '0.742 mm (90 %: 0.672 to 0.813)'."""
    factor, name = displayed(unit, value)
    low, high = (plain(factor * end, digits) for end in interval)
    unit_word = "" if name == "1" else f" {name}"
    return f"{plain(factor * value, digits)}{unit_word} (90 %: {low} to {high})"


def probability_words(p: float) -> str:
    """A probability as it is told: near 0 and 1 by its limit."""
    if p > 0.9995:
        return "P > 0.999"
    return "P < 0.001" if p < 0.0005 else f"P = {p:.2g}" if p < 0.95 else f"P = {p:.3f}"


def one_of(names: Sequence[str]) -> str:
    """'A', 'A or B', 'A, B or C'."""
    return " or ".join(filter(None, [", ".join(names[:-1]), *names[-1:]]))


def table(rows: Sequence[tuple[str, ...]]) -> str:
    """Text table; the first column is left-aligned, the others right-aligned."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    out = []
    for row in rows:
        cells = [
            cell.ljust(w) if i == 0 else cell.rjust(w)
            for i, (cell, w) in enumerate(zip(row, widths, strict=True))
        ]
        out.append("  ".join(cells).rstrip())
    return "\n".join(out)
