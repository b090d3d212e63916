# SPDX-License-Identifier: Apache-2.0
"""Conversion of the units in files to SI: one table of units, and products and quotients of them.

Factors are exact by definition, or follow from such
(NIST Special Publication 811, 2008, appendix B).
"""

from __future__ import annotations

import itertools
import math
import re
from collections import Counter
from functools import lru_cache

import numpy as np

from flatplank_data.errors import FlatplankError

_POUND, _GRAVITY, _INCH = 0.45359237, 9.80665, 0.0254
_POUND_FORCE = _POUND * _GRAVITY

#: unit in lower case -> SI unit, factor; value_si = value * factor
UNITS: dict[str, tuple[str, float]] = {
    "s": ("s", 1.0),
    "ms": ("s", 1e-3),
    "us": ("s", 1e-6),
    "ns": ("s", 1e-9),
    "min": ("s", 60.0),
    "h": ("s", 3600.0),
    "d": ("s", 86400.0),
    "m": ("m", 1.0),
    "mm": ("m", 1e-3),
    "cm": ("m", 1e-2),
    "km": ("m", 1e3),
    "in": ("m", _INCH),
    "ft": ("m", 12.0 * _INCH),
    "mi": ("m", 63360.0 * _INCH),
    "rad": ("rad", 1.0),
    "mrad": ("rad", 1e-3),
    "deg": ("rad", math.pi / 180.0),
    "gon": ("rad", math.pi / 200.0),
    "rev": ("rad", 2.0 * math.pi),
    "n": ("N", 1.0),
    "dan": ("N", 10.0),
    "kn": ("N", 1e3),
    "kgf": ("N", _GRAVITY),
    "lbf": ("N", _POUND_FORCE),
    "kip": ("N", 1e3 * _POUND_FORCE),
    "pa": ("Pa", 1.0),
    "hpa": ("Pa", 1e2),
    "kpa": ("Pa", 1e3),
    "mpa": ("Pa", 1e6),
    "bar": ("Pa", 1e5),
    "mbar": ("Pa", 1e2),
    "atm": ("Pa", 101325.0),
    "psi": ("Pa", _POUND_FORCE / _INCH**2),
    "kg": ("kg", 1.0),
    "lb": ("kg", _POUND),
    "v": ("V", 1.0),
    "mv": ("V", 1e-3),
    "k": ("K", 1.0),
    "1": ("1", 1.0),
    "%": ("1", 1e-2),
    "nm": ("N m", 1.0),
    "knm": ("N m", 1e3),
    "nmm": ("N m", 1e-3),
    "g": ("m/s2", _GRAVITY),
    "mph": ("m/s", 63360.0 * _INCH / 3600.0),
    "kph": ("m/s", 1.0 / 3.6),
    "rpm": ("rad/s", math.pi / 30.0),
    "1/min": ("rad/s", math.pi / 30.0),
}
#: unit -> SI unit, factor, offset; value_si = value * factor + offset
WITH_OFFSET = {
    "degc": ("K", 1.0, 273.15),
    "degf": ("K", 5.0 / 9.0, 459.67 * 5.0 / 9.0),
}
#: a mass as the unit of a force: its weight
WEIGHTS = {"kg": "kgf", "lb": "lbf"}

_SPELLINGS = {
    **dict.fromkeys(("", "-", "none", "bool", "dimensionless", "unitless"), "1"),
    **dict.fromkeys(("degree", "degrees", "degs"), "deg"),
    **dict.fromkeys(("radian", "radians"), "rad"),
    **dict.fromkeys(("u/min", "r/min", "revs/min"), "1/min"),
    **dict.fromkeys(("sec", "secs", "second", "seconds"), "s"),
    **dict.fromkeys(("msec", "millisecond", "milliseconds"), "ms"),
    **dict.fromkeys(("usec", "µs", "μs"), "us"),
    **dict.fromkeys(("minute", "minutes"), "min"),
    **dict.fromkeys(("hr", "hrs", "hour", "hours"), "h"),
    **dict.fromkeys(("day", "days"), "d"),
    **dict.fromkeys(("meter", "meters", "metre", "metres"), "m"),
    **dict.fromkeys(("inch", "inches"), "in"),
    **dict.fromkeys(("foot", "feet"), "ft"),
    **dict.fromkeys(("mile", "miles"), "mi"),
    **dict.fromkeys(("turn", "turns", "rot", "revs"), "rev"),
    **dict.fromkeys(("newton", "newtons"), "n"),
    **dict.fromkeys(("lbs", "pound", "pounds"), "lb"),
    **dict.fromkeys(("lbsf", "poundforce"), "lbf"),
    **dict.fromkeys(("kp", "kilopond"), "kgf"),
    **dict.fromkeys(("perc", "percent", "pct"), "%"),
    **dict.fromkeys(("c", "celsius"), "degc"),
    **dict.fromkeys(("f", "fahrenheit"), "degf"),
    **dict.fromkeys(("kmh", "kmph"), "kph"),
    **dict.fromkeys(("ftlb", "lbft", "ftlbs", "ftlbf", "lbfft"), "ft lbf"),
    **dict.fromkeys(("inlb", "lbin", "inlbs", "inlbf", "lbfin"), "in lbf"),
}  # fmt: skip
_SIGNS = str.maketrans({"°": "deg", "º": "deg", "²": "2", "^": "", "·": " ", "⋅": " ", "×": " "})
_BRACKETS = {"[": "]", "(": ")", "{": "}", '"': '"', "'": "'"}
_PRESSURE = re.compile(
    r"(pa|hpa|kpa|mpa|bar|mbar|psi|kgf?/cm2)[ _]?"
    r"(?:\(?(?P<gauge>g|ga|gauge|gage|rel|ü)\)?|\(?(?P<absolute>a|abs|absolute)\)?)"
)
_FACTOR = re.compile(r"([a-zµμ%]+|1)(-?[1-9])?")

Conversion = tuple[str, float, float]
"""SI unit, factor, offset"""


@lru_cache(maxsize=1024)
def conversions(unit: str) -> tuple[Conversion, ...]:
    """All meanings of a unit as written in a file; empty when it is not known."""
    text = _plain(unit)
    gauge = _PRESSURE.fullmatch(text)
    if gauge and gauge["gauge"]:
        text = gauge[1]
    for known in (text, text.replace(" ", ""), text.replace(".", " ").replace(" ", "")):
        known = _SPELLINGS.get(known, known)
        if known in WITH_OFFSET:
            return (WITH_OFFSET[known],)
        if known in UNITS:
            return tuple((si, factor, 0.0) for si, factor in _meanings(known))
        if known != text and known in _SPELLINGS.values():
            return _product(known)
    return _product(text)


def _plain(unit: str) -> str:
    """The unit in lower case without enclosing brackets."""
    text = unit.strip()
    while len(text) > 1 and _BRACKETS.get(text[0]) == text[-1]:
        text = text[1:-1].strip()
    text = text.lower().translate(_SIGNS).replace("**", "").replace(" per ", "/")
    return " ".join(text.split()).rstrip(".")


def _meanings(atom: str) -> list[tuple[str, float]]:
    weight = WEIGHTS.get(atom)
    return [UNITS[atom], UNITS[weight]] if weight else [UNITS[atom]]


def _product(text: str) -> tuple[Conversion, ...]:
    """Meanings of products and quotients: `lbf-ft`, `km/h`, `m/s2`."""
    factors: list[list[tuple[str, float, int]]] = []
    for k, part in enumerate(text.replace("*", " ").split("/")):
        # the hyphen of `ft-lb` multiplies, that of `s-1` is a sign
        for word in re.split(r"[ .]|-(?![0-9])", part):
            match = _FACTOR.fullmatch(word)
            atom = _SPELLINGS.get(match[1], match[1]) if match else ""
            if atom not in UNITS or match is None:
                return ()
            power = int(match[2] or 1) * (-1 if k else 1)
            factors.append([(si, f, power) for si, f in _meanings(atom)])
    found = {}
    for choice in itertools.product(*factors):
        dimension: Counter[str] = Counter()
        for si, _, power in choice:
            for base, exponent in _dimension(si).items():
                dimension[base] += exponent * power
        found[_named(dimension)] = math.prod(f**power for _, f, power in choice)
    return tuple((si, factor, 0.0) for si, factor in found.items() if si)


@lru_cache
def _dimension(si: str) -> Counter[str]:
    """Exponents of the parts of an SI unit: `m/s2` is m: 1, s: -2."""
    out: Counter[str] = Counter()
    top, _, bottom = si.partition("/")
    for part, sign in ((top, 1), (bottom, -1)):
        for word in part.split():
            base = word.rstrip("0123456789")
            if base:
                out[base] += sign * int(word[len(base) :] or 1)
    return out


_NAMED = ("m", "s", "N", "kg", "rad", "Pa", "V", "K", "m/s", "m/s2", "rad/s", "N m", "N/m", "1")


def _named(dimension: Counter[str]) -> str:
    """SI unit with these exponents; "" for a quantity that no column has."""
    used = {k: v for k, v in dimension.items() if v}
    if used == {"N": 1, "m": -2}:
        return "Pa"
    return next((si for si in _NAMED if {k: v for k, v in _dimension(si).items()} == used), "")


def is_unit(text: str) -> bool:
    """True for a known unit that is written with a letter or a sign, not for `1`, `-` or ``."""
    return bool(conversions(text)) and not is_bare(text)


def is_bare(unit: str) -> bool:
    """True for a unit that only says that a number has none: `-`, `1`, `none`, ``."""
    return _SPELLINGS.get(_plain(unit), _plain(unit)) == "1"


def factor_offset(unit: str, expected: str, where: str) -> tuple[float, float]:
    """Factor and offset that turn values in `unit` into the SI unit `expected`.

    Pounds and kilograms of a force are their weight.

    Raises:
        FlatplankError: the unit is not known, or belongs to another quantity.
    """
    meanings = conversions(unit)
    for si, factor, offset in meanings:
        if si == expected:
            return factor, offset
    pressure = _PRESSURE.fullmatch(_plain(unit))
    if pressure and pressure["absolute"]:
        raise FlatplankError(
            f"'{unit}' is an absolute pressure", where,
            "subtract the pressure of the air, and write the pressure over it",
        )  # fmt: skip
    if not meanings:
        raise FlatplankError(
            f"unknown unit '{unit}'", where, f"write a unit that converts to {expected}"
        )
    raise FlatplankError(
        f"unit '{unit}' does not fit a quantity in {expected}", where,
        "correct the unit or the column name",
    )  # fmt: skip


def to_si(values: np.ndarray, unit: str, expected: str, where: str) -> np.ndarray:
    """`values` in `unit` as float64 in the SI unit `expected`."""
    factor, offset = factor_offset(unit, expected, where)
    return np.asarray(values, dtype=np.float64) * factor + offset


def units_of(expected: str) -> dict[str, float]:
    """Units of a quantity of the SI unit `expected`, and their factors to it."""
    found = {unit: factor for unit, (si, factor) in UNITS.items() if si == expected}
    return found | {u: factor_offset(u, expected, "")[0] for u in _COMPOUND.get(expected, ())}


_COMPOUND = {"m/s": ("mm/s", "ft/s"), "rad/s": ("deg/s",)}
