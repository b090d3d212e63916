# SPDX-License-Identifier: Apache-2.0
"""Tire files and their forces, with numpy alone.

    from flatplank_tire import read_tir, steady_forces
    tire = read_tir("tire.tir")
    fx, fy, mz = steady_forces(tire.coefficients, fz=4000.0, alpha=0.05)

A `.tir` is of Magic Formula 5.2, 6.0 to 6.2 or of PAC2002; a TYDEX file holds a measurement. SI
units, ISO W axes. Names are imported on first use: nodes need the errors alone.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from flatplank_tire.errors import FlatplankError
    from flatplank_tire.magic_formula import Coefficients, steady_forces
    from flatplank_tire.tir import TirFile, parse_tir, read_tir, shipped_tir, write_tir
    from flatplank_tire.tydex import TydexFile, format_tydex, parse_tydex

__all__ = [
    "Coefficients",
    "FlatplankError",
    "TirFile",
    "TydexFile",
    "format_tydex",
    "parse_tir",
    "parse_tydex",
    "read_tir",
    "shipped_tir",
    "steady_forces",
    "write_tir",
]
_HOMES = {
    "errors": ("FlatplankError",),
    "magic_formula": ("Coefficients", "steady_forces"),
    "tir": ("TirFile", "parse_tir", "read_tir", "shipped_tir", "write_tir"),
    "tydex": ("TydexFile", "format_tydex", "parse_tydex"),
}
_HOME = {name: module for module, names in _HOMES.items() for name in names}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    return getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)
