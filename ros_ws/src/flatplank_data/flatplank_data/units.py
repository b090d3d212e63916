# SPDX-License-Identifier: Apache-2.0
"""Conversion of the units in files to SI."""

from __future__ import annotations

import math

import numpy as np

from flatplank_data.errors import FlatplankError

#: unit -> (SI unit, factor, offset): value_si = value * factor + offset
UNITS: dict[str, tuple[str, float, float]] = {
    "s": ("s", 1.0, 0.0),
    "ms": ("s", 1e-3, 0.0),
    "us": ("s", 1e-6, 0.0),
    "ns": ("s", 1e-9, 0.0),
    "min": ("s", 60.0, 0.0),
    "h": ("s", 3600.0, 0.0),
    "m": ("m", 1.0, 0.0),
    "mm": ("m", 1e-3, 0.0),
    "cm": ("m", 1e-2, 0.0),
    "km": ("m", 1e3, 0.0),
    "in": ("m", 0.0254, 0.0),
    "ft": ("m", 0.3048, 0.0),
    "m/s": ("m/s", 1.0, 0.0),
    "mm/s": ("m/s", 1e-3, 0.0),
    "km/h": ("m/s", 1.0 / 3.6, 0.0),
    "kph": ("m/s", 1.0 / 3.6, 0.0),
    "mph": ("m/s", 0.44704, 0.0),
    "m/s2": ("m/s2", 1.0, 0.0),
    "g": ("m/s2", 9.80665, 0.0),
    "rad": ("rad", 1.0, 0.0),
    "deg": ("rad", math.pi / 180.0, 0.0),
    "rev": ("rad", 2.0 * math.pi, 0.0),
    "rad/s": ("rad/s", 1.0, 0.0),
    "deg/s": ("rad/s", math.pi / 180.0, 0.0),
    "rpm": ("rad/s", math.pi / 30.0, 0.0),
    "1/min": ("rad/s", math.pi / 30.0, 0.0),
    "n": ("N", 1.0, 0.0),
    "dan": ("N", 10.0, 0.0),
    "kn": ("N", 1e3, 0.0),
    "kgf": ("N", 9.80665, 0.0),
    "lbf": ("N", 4.4482216152605, 0.0),
    "nm": ("N m", 1.0, 0.0),
    "knm": ("N m", 1e3, 0.0),
    "nmm": ("N m", 1e-3, 0.0),
    "pa": ("Pa", 1.0, 0.0),
    "hpa": ("Pa", 1e2, 0.0),
    "kpa": ("Pa", 1e3, 0.0),
    "mpa": ("Pa", 1e6, 0.0),
    "bar": ("Pa", 1e5, 0.0),
    "mbar": ("Pa", 1e2, 0.0),
    "psi": ("Pa", 6894.757293168, 0.0),
    "kg": ("kg", 1.0, 0.0),
    "n/m": ("N/m", 1.0, 0.0),
    "n/mm": ("N/m", 1e3, 0.0),
    "v": ("V", 1.0, 0.0),
    "mv": ("V", 1e-3, 0.0),
    "k": ("K", 1.0, 0.0),
    "degc": ("K", 1.0, 273.15),
    "1": ("1", 1.0, 0.0),
    "-": ("1", 1.0, 0.0),
    "": ("1", 1.0, 0.0),
    "%": ("1", 1e-2, 0.0),
}

_SPELLINGS = {
    "°": "deg",
    "degree": "deg",
    "degrees": "deg",
    "°/s": "deg/s",
    "u/min": "1/min",
    "r/min": "1/min",
    "sec": "s",
    "newton": "n",
    "perc": "%",
    "°c": "degc",
    "c": "degc",
    "celsius": "degc",
    "none": "-",
    "bool": "-",
    "m/s^2": "m/s2",
    "m/s**2": "m/s2",
}


def is_number_text(text: str) -> bool:
    """True when a text is one number."""
    try:
        float(text)
    except ValueError:
        return False
    return True


def canonical_unit(unit: str) -> str:
    """Key of `UNITS` for a unit as written in a file, without the dot or blank of a product."""
    text = unit.strip().strip("[]()'\"").strip()
    key = text.lower()
    key = _SPELLINGS.get(key, key)
    if key in UNITS:
        return key
    for mark in (" ", "*", ".", "·", "-"):
        key = key.replace(mark, "")
    return _SPELLINGS.get(key, key)


def factor_offset(unit: str, expected: str, where: str) -> tuple[float, float]:
    """Factor and offset that turn values in `unit` into the SI unit `expected`."""
    entry = UNITS.get(canonical_unit(unit))
    if entry is None:
        raise FlatplankError(
            f"unknown unit '{unit}'", where, f"write a unit that converts to {expected}"
        )
    si, factor, offset = entry
    if si != expected:
        raise FlatplankError(
            f"unit '{unit}' does not fit a quantity in {expected}",
            where,
            "correct the unit or the column name",
        )
    return factor, offset


def to_si(values: np.ndarray, unit: str, expected: str, where: str) -> np.ndarray:
    """`values` in `unit` as float64 in the SI unit `expected`."""
    factor, offset = factor_offset(unit, expected, where)
    array = np.asarray(values, dtype=np.float64)
    if factor == 1.0 and offset == 0.0:
        return array
    return array * factor + offset
