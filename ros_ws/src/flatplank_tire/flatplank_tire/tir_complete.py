# SPDX-License-Identifier: Apache-2.0
"""A complete tire property file for other programs, independent of a reader's own defaults.

Programs differ in their defaults for a missing coefficient (BREFF = 8.4 here, 0 there), and some
refuse a file without header, units, ranges or a section. A complete file has every coefficient
of its law, with the value that this project computes with, and the range in which it was fitted.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from flatplank_tire.magic_formula import DEFAULTS, NOT_OF, SECTIONS
from flatplank_tire.magic_formula.coefficients import factor
from flatplank_tire.tir import Entry, TirFile

HEAD: dict[str, dict[str, str]] = {
    "MDI_HEADER": {"FILE_TYPE": "'tir'", "FILE_VERSION": "3.0", "FILE_FORMAT": "'ASCII'"},
    "UNITS": {"LENGTH": "'meter'", "FORCE": "'newton'", "ANGLE": "'radians'", "MASS": "'kg'",
              "TIME": "'second'"},
    "MODEL": {"FITTYP": "61", "TYRESIDE": "'LEFT'", "LONGVL": "16.7", "VXLOW": "0.0",
              "ROAD_INCREMENT": "0.01", "ROAD_DIRECTION": "1"},
    "INERTIA": {"MASS": "0.0", "IXX": "0.0", "IYY": "0.0", "BELT_MASS": "0.0", "BELT_IXX": "0.0",
                "BELT_IYY": "0.0", "GRAVITY": "-9.81"},
}  # fmt: skip
"""sections of every file, with values for keys that the tire does not give; the bench does not
weigh tires, and a mass of 0 adds none to the wheel"""
RANGES: dict[str, tuple[str, str, str, tuple[float, float]]] = {
    "INFLATION_PRESSURE_RANGE": ("PRESMIN", "PRESMAX", "pressure", (1e4, 1e6)),
    "VERTICAL_FORCE_RANGE": ("FZMIN", "FZMAX", "fz", (0.0, 1e5)),
    "LONG_SLIP_RANGE": ("KPUMIN", "KPUMAX", "kappa", (-1.0, 1.0)),
    "SLIP_ANGLE_RANGE": ("ALPMIN", "ALPMAX", "alpha", (-1.5, 1.5)),
    "INCLINATION_ANGLE_RANGE": ("CAMMIN", "CAMMAX", "gamma", (-0.25, 0.25)),
}
"""section -> its two keys, the quantity, and its widest range, for none measured [SI]"""
OWN = "FLATPLANK"
"""prefix of this project's sections, ignored by other programs; written only if the file has
them"""


def complete_tir(tir: TirFile, ranges: Mapping[str, tuple[float, float]] | None = None) -> TirFile:
    """The same tire with every coefficient of its law written.

    ranges: quantity (fz, kappa, alpha, gamma, pressure) -> lowest and highest value [SI].
    """
    given, units = tir.values, tir.units
    known = DEFAULTS | {"INFLPRES": given.get("NOMPRES", math.nan)} | given
    numbers: dict[str, dict[str, float]] = {}
    for name, keys in SECTIONS.items():
        names = [k for k in keys.split() if k not in NOT_OF[tir.law] and math.isfinite(known[k])]
        if not name.startswith(OWN):
            numbers[name] = {k: known[k] for k in names}
    for name, (low, high, quantity, wide) in RANGES.items():
        if ranges is not None or name not in tir.sections:
            numbers[name] = dict(zip((low, high), (ranges or {}).get(quantity, wide), strict=True))
    sections = {name: {k: Entry(v) for k, v in keys.items()} for name, keys in HEAD.items()}
    for name, values in numbers.items():
        found = {k: Entry(repr(float(v) / factor(k, units))) for k, v in values.items()}
        sections.setdefault(name, {}).update(found)
    for name, entries in tir.sections.items():
        said = {k: e for k, e in entries.items() if e.value and k not in numbers.get(name, {})}
        sections.setdefault(name, {}).update(said)
    return TirFile(sections, tir.kept, tir.path)
