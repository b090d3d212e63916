# SPDX-License-Identifier: Apache-2.0
"""Shapes of an effect over a coordinate: the modules of this folder, each of which has SHAPE."""

from __future__ import annotations

import importlib
import pkgutil
from functools import lru_cache
from pathlib import Path

from flatplank_analysis.proposal.shapes.base import Shape

_NO_SHAPES = {"base", "operators"}


@lru_cache(maxsize=1)
def shapes() -> dict[str, Shape]:
    """All shapes by name, the simplest first."""
    names = sorted(i.name for i in pkgutil.iter_modules([str(Path(__file__).parent)]))
    modules = [importlib.import_module(f"{__name__}.{n}") for n in names if n not in _NO_SHAPES]
    found = [module.SHAPE for module in modules]
    return {s.name: s for s in sorted(found, key=lambda s: (s.price, s.name))}
