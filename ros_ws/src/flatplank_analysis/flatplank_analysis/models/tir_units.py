# SPDX-License-Identifier: Apache-2.0
"""Units of a tire property file: what a file may be written in, and the factor to SI of a key.

The section [UNITS] holds for the numbers that have a dimension. The coefficients of the Magic
Formula have none, or are per radian whatever the file's unit of angle.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import prod

UNITS: dict[str, dict[str, float]] = {
    "LENGTH": {
        "meter": 1.0, "metre": 1.0, "m": 1.0, "mm": 1e-3, "millimeter": 1e-3, "cm": 1e-2,
        "centimeter": 1e-2, "km": 1e3, "inch": 0.0254, "in": 0.0254, "foot": 0.3048, "ft": 0.3048,
    },
    "FORCE": {
        "newton": 1.0, "n": 1.0, "kn": 1e3, "kilonewton": 1e3, "knewton": 1e3,
        "pound_force": 4.4482216152605, "lbf": 4.4482216152605, "kg_force": 9.80665,
        "kgf": 9.80665,
    },
    "ANGLE": {
        "radians": 1.0, "radian": 1.0, "rad": 1.0, "degrees": 1.0, "degree": 1.0, "deg": 1.0,
    },
    "MASS": {
        "kg": 1.0, "kilogram": 1.0, "gram": 1e-3, "g": 1e-3, "pound_mass": 0.45359237,
        "lbm": 0.45359237, "slug": 14.59390294,
    },
    "TIME": {
        "second": 1.0, "sec": 1.0, "s": 1.0, "millisecond": 1e-3, "ms": 1e-3, "minute": 60.0,
        "hour": 3600.0,
    },
    "PRESSURE": {
        "pascal": 1.0, "pa": 1.0, "kpa": 1e3, "kilopascal": 1e3, "mpa": 1e6, "bar": 1e5,
        "psi": 6894.757293168,
    },
}  # fmt: skip
"""quantity of [UNITS] -> name, in lower case, -> factor to SI"""
_BY_POWERS: tuple[tuple[dict[str, int], str], ...] = (
    ({"LENGTH": 1}, "UNLOADED_RADIUS WIDTH RIM_RADIUS RIM_WIDTH"),
    ({"LENGTH": 1, "TIME": -1}, "LONGVL VXLOW"),
    ({"PRESSURE": 1}, "INFLPRES NOMPRES PRESMIN PRESMAX"),
    ({"FORCE": 1}, "FNOMIN FZMIN FZMAX"),
    ({"FORCE": 1, "LENGTH": -1}, "VERTICAL_STIFFNESS LONGITUDINAL_STIFFNESS LATERAL_STIFFNESS"),
    ({"FORCE": 1, "LENGTH": 1}, "YAW_STIFFNESS"),
    ({"FORCE": 1, "TIME": 1, "LENGTH": -1}, "VERTICAL_DAMPING"),
)
DIMENSIONS = {key: powers for powers, keys in _BY_POWERS for key in keys.split()}
"""key -> powers of its units; a key that is not here is a pure number"""


def factor(key: str, units: Mapping[str, float]) -> float:
    """SI value of a key over the number in the file; `units`: factor of each quantity."""
    return prod(units.get(name, 1.0) ** power for name, power in DIMENSIONS.get(key, {}).items())
