# SPDX-License-Identifier: Apache-2.0
"""Effects in sweeps: every file of this folder is one."""

from __future__ import annotations

import importlib
import pkgutil

from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.effects.sweep_base import SweepEffect


def effects() -> list[type[SweepEffect]]:
    """All effects, by file and by their order there."""
    found = []
    for module in sorted(m.name for m in pkgutil.iter_modules(__path__)):
        content = vars(importlib.import_module(f"{__name__}.{module}")).values()
        found += [
            one for one in content
            if isinstance(one, type) and issubclass(one, SweepEffect) and one.identifier
        ]  # fmt: skip
    return found


def that_can_show(runs: RunSet) -> list[type[SweepEffect]]:
    """Effects that these sweeps can show."""
    return [effect for effect in effects() if effect.can_show(runs)]
