# SPDX-License-Identifier: Apache-2.0
"""Shapes of an effect over a coordinate: every `Shape` at the top of a module of this folder."""

from __future__ import annotations

import importlib
import pkgutil
from functools import lru_cache

from flatplank_analysis.effects.grammar.shapes.base import Shape


@lru_cache(maxsize=1)
def shapes() -> dict[str, Shape]:
    """All shapes by name, the simplest first."""
    modules = [
        importlib.import_module(f"{__name__}.{m.name}") for m in pkgutil.iter_modules(__path__)
    ]
    tops = [value for module in modules for value in vars(module).values()]
    found = [s for top in tops for s in (top if isinstance(top, tuple) else (top,))]
    known = sorted((s for s in found if isinstance(s, Shape)), key=lambda s: (s.price, s.name))
    return {s.name: s for s in known}
