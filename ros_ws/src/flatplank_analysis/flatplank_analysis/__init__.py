# SPDX-License-Identifier: Apache-2.0
"""Analysis of flat plank measurements: bags -> tables -> models -> comparison -> report.

For notebooks and scripts: `load`, `fit`, `diagnose`, `write_report`, `sweeps`, and `Motion` with
`explain` for machines that are no tires (docs/python.md).
They are imported when they are asked for: nodes import this package, too, and need none of it.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from flatplank_analysis.api.diagnosis import Diagnosed, diagnose
    from flatplank_analysis.api.machines import explain, script
    from flatplank_analysis.api.model import Comparison, Model, fit
    from flatplank_analysis.api.report import write_report
    from flatplank_analysis.api.runs import Run, load
    from flatplank_analysis.api.sweeps import Sweeps, sweeps
    from flatplank_analysis.discovery.parameters import param
    from flatplank_analysis.machines.declared import Missing
    from flatplank_analysis.machines.files import column, read_table
    from flatplank_analysis.machines.motion import Motion
    from flatplank_analysis.machines.records import Record, table_of
    from flatplank_analysis.machines.swings import half_swings
    from flatplank_data.errors import FlatplankError

__all__ = [
    "Comparison",
    "Diagnosed",
    "FlatplankError",
    "Missing",
    "Model",
    "Motion",
    "Record",
    "Run",
    "Sweeps",
    "column",
    "diagnose",
    "explain",
    "fit",
    "half_swings",
    "load",
    "param",
    "read_table",
    "script",
    "sweeps",
    "table_of",
    "write_report",
]
_HOMES = {
    "api.runs": ("Run", "load"),
    "api.model": ("Comparison", "Model", "fit"),
    "api.diagnosis": ("Diagnosed", "diagnose"),
    "api.report": ("write_report",),
    "api.sweeps": ("Sweeps", "sweeps"),
    "api.machines": ("explain", "script"),
    "machines.declared": ("Missing",),
    "machines.files": ("column", "read_table"),
    "machines.motion": ("Motion",),
    "machines.records": ("Record", "table_of"),
    "machines.swings": ("half_swings",),
    "discovery.parameters": ("param",),
    "errors": ("FlatplankError",),
}
_HOME = {name: module for module, names in _HOMES.items() for name in names}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    return getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
