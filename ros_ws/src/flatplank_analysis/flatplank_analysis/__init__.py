# SPDX-License-Identifier: Apache-2.0
"""Analysis of flat plank measurements: bags -> tables -> models -> comparison -> report.

For notebooks and scripts: `load`, `fit`, `diagnose`, `write_report` and `sweeps` (docs/python.md).
They are imported when they are asked for: nodes import this package, too, and need none of it.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from flatplank_analysis.api.diagnosis import Diagnosed, diagnose
    from flatplank_analysis.api.model import Comparison, Model, fit
    from flatplank_analysis.api.report import write_report
    from flatplank_analysis.api.runs import Run, load
    from flatplank_analysis.api.sweeps import Sweeps, sweeps
    from flatplank_analysis.errors import FlatplankError

__all__ = [
    "Comparison",
    "Diagnosed",
    "FlatplankError",
    "Model",
    "Run",
    "Sweeps",
    "diagnose",
    "fit",
    "load",
    "sweeps",
    "write_report",
]
_HOMES = {
    "api.runs": ("Run", "load"),
    "api.model": ("Comparison", "Model", "fit"),
    "api.diagnosis": ("Diagnosed", "diagnose"),
    "api.report": ("write_report",),
    "api.sweeps": ("Sweeps", "sweeps"),
    "errors": ("FlatplankError",),
}
_HOME = {name: module for module, names in _HOMES.items() for name in names}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    return getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
