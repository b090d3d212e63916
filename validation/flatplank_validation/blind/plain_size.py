# SPDX-License-Identifier: Apache-2.0
"""Size in the plain law that comes closest to a fault of another form.

The number of a fault of another form is a coefficient of its own law: the crosstalk of a small
force, where the crosstalk saturates. A diagnosis states the size of the plain law that fits the
runs. The first is converted with the machine `second`, whose laws are plain: its size is sought
whose change of the forces is closest to that of the fault, beside all that a fit of the tire
takes, in the noise and scatter of the campaign. Nothing of the diagnosis is used.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from flatplank_validation.blind.detectable import (
    cache,
    distance,
    factors_of,
    kit_version,
    noise_free,
)
from flatplank_validation.blind.kept import kept

OTHER_FORMS, PLAIN = "forms", "second"
DRAWN = ("mesh_ripple", "load_undulation", "worn_patch")
"""effects whose place or period each machine draws itself; their sizes mean the same in both"""
RANGE = (0.2, 3.0)
"""smallest and largest size that is tried, relative to the hidden one"""
CLOSE = 0.01
"""relative tolerance of the size"""


def with_plain_sizes(entry: dict[str, Any]) -> dict[str, Any]:
    """A journal entry whose hidden effects have their `plain` size, where that may differ."""
    case, answer = entry["case"], entry["answer"]
    if answer is None or case["world"] != OTHER_FORMS:
        return entry
    effects = [e | {"plain": plain_size(case, e["name"], e["size"])} for e in answer["effects"]]
    return entry | {"answer": answer | {"effects": effects}}


def by_plain_sizes(entry: Mapping[str, Any]) -> Mapping[str, Any]:
    """The entry with every hidden size replaced by its plain one."""
    effects = [e | {"size": e.get("plain", e["size"])} for e in entry["answer"]["effects"]]
    return {**entry, "answer": entry["answer"] | {"effects": effects}}


def plain_size(case: Mapping[str, Any], name: str, size: float) -> float:
    """Size of the plain law; cached in a file beside the journals, since each takes seconds."""
    if name in DRAWN:
        return size
    around = case["noise"], case["scatter"], case["design"]
    key = "/".join(map(str, (name, repr(size), *around)))
    path = cache() / f"plain-sizes-{kit_version()}.txt"
    return kept(path, key, lambda: size * _closest(name, size, *around))


def _closest(name: str, size: float, noise: str, scatter: float, design: str) -> float:
    """Size of the plain law over the hidden size."""
    other, plain = noise_free(OTHER_FORMS, design), noise_free(PLAIN, design)
    goal, factors = other.change(name, size), factors_of(OTHER_FORMS, design, noise, scatter)

    def left(log: float) -> float:
        rest = goal - plain.change(name, size * float(np.exp(log)))
        return distance(rest, other.base, factors)

    bounds = tuple(np.log(RANGE))
    found = minimize_scalar(left, bounds=bounds, method="bounded", options={"xatol": CLOSE})
    return float(np.exp(found.x))
