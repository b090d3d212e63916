# SPDX-License-Identifier: Apache-2.0
"""Formats numbers for people."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np


def with_unit(name: str, unit: str) -> str:
    """Axis label: the name, with the unit where there is one."""
    return name if unit in (*NO_UNIT, "1") else f"{name} [{unit}]"


def axis_of(name: str, unit: str, ends: Sequence[float]) -> tuple[float, str]:
    """Factor from SI to the display unit, and the label, of an axis with these ends."""
    factor, shown = displayed(unit, *map(float, ends))
    return factor, with_unit(name, shown)


def six_digits(value: float) -> float | None:
    """A number rounded for programs; None when it is not finite."""
    return float(f"{value:.6g}") if np.isfinite(value) else None


SEEN = 1e-7
"""numbers below this are printed as 0, in whatever display unit"""


def plain(value: float, digits: int = 3) -> str:
    """The number with significant digits, without powers of ten; 0 for one below `SEEN`."""
    if not np.isfinite(value):
        return f"{value:g}"
    if abs(value) < SEEN:
        return "0"
    return np.format_float_positional(
        value, precision=digits, unique=False, fractional=False, trim="-"
    )


def brief(value: float, digits: int = 1) -> str:
    """The number with `digits` decimals; below 1 with two significant digits."""
    return f"{value:.{digits}f}" if abs(value) >= 1.0 or value == 0.0 else plain(value, 2)


SMALL = 0.1
"""lengths below this are written in mm [m]"""
DISPLAYED = {"1": (100.0, "%"), "1/N": (1e5, "%/kN"), "rad": (math.degrees(1.0), "deg")}
"""factor and display unit: of a share, of a share per force, of an angle"""
NO_UNIT = ("", "-")
"""units of a plain factor, or of a number that counts: they are not printed"""


def displayed(unit: str, *values: float) -> tuple[float, str]:
    """Factor and display unit: mm for small lengths, deg for rad, % for shares."""
    if unit == "m" and values and max(map(abs, values)) < SMALL:
        return 1e3, "mm"
    return DISPLAYED.get(unit, (1.0, unit))


def behind(text: str, unit: str) -> str:
    """A printed number with its display unit behind it."""
    return text if unit in NO_UNIT else f"{text} {unit}"


def quantity(value: float, unit: str, digits: int = 3, axis: Sequence[float] = ()) -> str:
    """A number [SI] in its display unit, or in that of the axis whose ends are given."""
    factor, name = displayed(unit, *(axis or (value,)))
    return behind(plain(factor * value, digits), name)


def span(low: float, high: float, unit: str, digits: int = 3, axis: Sequence[float] = ()) -> str:
    """A range in its display unit, or in that of the axis whose ends are given: '1.54 to 1.64
    m'; an end that is nothing beside the other is 0."""
    factor, name = displayed(unit, *(axis or (low, high)))
    least = 0.1**digits * max((abs(end) for end in (low, high) if np.isfinite(end)), default=0.0)
    ends = (plain(factor * end if abs(end) >= least else 0.0, digits) for end in (low, high))
    return behind(" to ".join(ends), name)


def sized(value: float, interval: Sequence[float], unit: str, digits: int = 3) -> str:
    """A value with its 90 % interval: '0.742 mm (90 %: 0.672 to 0.813 mm)'."""
    low, high = interval
    own = quantity(value, unit, digits)
    return f"{own} (90 %: {span(low, high, unit, digits, axis=(value,))})"


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
