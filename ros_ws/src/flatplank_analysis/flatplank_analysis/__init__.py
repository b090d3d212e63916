# SPDX-License-Identifier: Apache-2.0
"""Analysis of flat plank measurements: bags -> tables -> models -> comparison -> report.

For notebooks and scripts: `load`, `fit`, `diagnose`, `write_report`, `catalogue`, `sweeps`, and
`Motion` with `explain` for machines that are not tires (docs/guide/python.md).
They are imported on first use, because ROS nodes import this package, too, and use none of them.
"""

from __future__ import annotations

import importlib
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from flatplank_analysis.api.diagnosis import Diagnosed, diagnose, script
    from flatplank_analysis.api.explained import Explained, explain
    from flatplank_analysis.api.model import Comparison, Model, fit
    from flatplank_analysis.api.runs import Run, load, write_report
    from flatplank_analysis.api.sweeps import Sweeps, sweeps
    from flatplank_analysis.catalogues.catalogue import Catalogue, catalogue
    from flatplank_analysis.discovery.effect import Effect
    from flatplank_analysis.discovery.model import ParameterSet
    from flatplank_analysis.discovery.parameters import Parameter, param
    from flatplank_analysis.discovery.runs import Coordinate, RunSet
    from flatplank_analysis.machines.files import column, read_table
    from flatplank_analysis.machines.motion import Missing, Motion
    from flatplank_analysis.machines.records import Record, half_swings, table_of
    from flatplank_data.errors import FlatplankError

__all__ = [
    "Catalogue",
    "Comparison",
    "Coordinate",
    "Diagnosed",
    "Effect",
    "Explained",
    "FlatplankError",
    "Missing",
    "Model",
    "Motion",
    "Parameter",
    "ParameterSet",
    "Record",
    "Run",
    "RunSet",
    "Sweeps",
    "catalogue",
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
    "flatplank_analysis.api.runs": ("Run", "load", "write_report"),
    "flatplank_analysis.api.model": ("Comparison", "Model", "fit"),
    "flatplank_analysis.api.diagnosis": ("Diagnosed", "diagnose", "script"),
    "flatplank_analysis.api.explained": ("Explained", "explain"),
    "flatplank_analysis.api.sweeps": ("Sweeps", "sweeps"),
    "flatplank_analysis.catalogues.catalogue": ("Catalogue", "catalogue"),
    "flatplank_analysis.machines.files": ("column", "read_table"),
    "flatplank_analysis.machines.motion": ("Missing", "Motion"),
    "flatplank_analysis.machines.records": ("Record", "half_swings", "table_of"),
    "flatplank_analysis.discovery.effect": ("Effect",),
    "flatplank_analysis.discovery.model": ("ParameterSet",),
    "flatplank_analysis.discovery.parameters": ("Parameter", "param"),
    "flatplank_analysis.discovery.runs": ("Coordinate", "RunSet"),
    "flatplank_data.errors": ("FlatplankError",),
}
_HOME = {name: module for module, names in _HOMES.items() for name in names}


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return version(__name__)
    if name not in _HOME:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    return getattr(importlib.import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted([*globals(), "__version__", *__all__])
