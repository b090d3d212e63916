# SPDX-License-Identifier: Apache-2.0
"""All defects by name. A new one is a class under `@register("name")` in a file of this folder."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable, Mapping
from dataclasses import fields
from functools import cache
from typing import Any, NamedTuple, TypeVar

from flatplank_data.params import nearest
from flatplank_sim.plant.defects.base import Defect
from flatplank_sim.plant.yamlconfig import PlantConfigError, build

D = TypeVar("D", bound=type[Defect])
_DEFECTS: dict[str, type[Defect]] = {}


class DefectInfo(NamedTuple):
    """One parameter of one defect."""

    defect: str
    parameter: str
    default: Any
    unit: str
    note: str
    bounds: tuple[float, float]


def register(name: str) -> Callable[[D], D]:
    """Put a defect under its YAML name."""

    def keep(cls: D) -> D:
        if name in _DEFECTS:
            raise ValueError(f"defect '{name}' exists twice")
        _DEFECTS[name] = cls
        return cls

    return keep


@cache
def defects() -> Mapping[str, type[Defect]]:
    """Name -> class."""
    package = importlib.import_module("flatplank_sim.plant.defects")
    for module in pkgutil.iter_modules(package.__path__):
        importlib.import_module(f"{package.__name__}.{module.name}")
    return dict(sorted(_DEFECTS.items()))


def describe() -> tuple[DefectInfo, ...]:
    """Every parameter of every defect with its unit."""
    return tuple(
        DefectInfo(
            name, f.name, f.default, f.metadata["unit"], f.metadata["note"], f.metadata["bounds"]
        )
        for name, cls in defects().items()
        for f in fields(cls)
    )


def build_defects(data: Mapping[str, Any], where: str) -> dict[str, Defect]:
    """Defects from YAML: {name: {parameter: value}}; null switches one off that was on."""
    if not isinstance(data, Mapping):
        raise PlantConfigError(f"{where}: expected names of defects, found {data!r}")
    known = defects()
    result: dict[str, Defect] = {}
    for name, values in data.items():
        if name not in known:
            raise PlantConfigError(f"{where}: unknown defect '{name}'{nearest(name, known)}")
        if values is None:
            continue
        defect = (
            values
            if isinstance(values, Defect)
            else build(known[name], values, f"{where}: {name}")
        )
        defect.check(f"{where}: {name}")
        result[name] = defect
    return result
