# SPDX-License-Identifier: Apache-2.0
"""Signs under which a tire file was fitted.

A `.tir` file says nothing of its axes, and not all programs that write one mean ISO W. A law of
another side of the car, or in the numbers of SAE, differs in its plysteer, its conicity and its
camber thrust. Each convention is one sign of the slip angle, of the camber and of the side force.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from flatplank_data.errors import FlatplankError
from flatplank_data.names import nearest_hint
from flatplank_tire.tir import TirFile

HALF = 0.5
"""share of the error below which another convention is told"""
READ = "iso"
"""convention in which a file is read"""


class TirSigns(NamedTuple):
    """Signs of what a law takes and gives, relative to ISO W."""

    title: str
    alpha: int
    gamma: int
    fy: int


CONVENTIONS = {
    READ: TirSigns("ISO W", 1, 1, 1),
    "mirrored": TirSigns("the other side of the car", -1, -1, -1),
    "sae": TirSigns("SAE J670", -1, 1, -1),
    "adapted": TirSigns("adapted SAE", 1, 1, -1),
    "camber": TirSigns("the camber counted the other way", 1, -1, 1),
    "alpha": TirSigns("the slip angle counted the other way", -1, 1, 1),
    "adapted_mirrored": TirSigns("adapted SAE, the other side of the car", -1, -1, 1),
    "adapted_camber": TirSigns("adapted SAE, the camber counted the other way", 1, -1, -1),
}


def convention(name: str) -> TirSigns:
    """A convention by name; FlatplankError for an unknown one."""
    if name not in CONVENTIONS:
        what = f"no convention '{name}'{nearest_hint(name, CONVENTIONS)}"
        raise FlatplankError(what, "--tir-signs", f"known: {', '.join(CONVENTIONS)}")
    return CONVENTIONS[name]


def errors_of(error: Callable[[TirSigns], Sequence[float]]) -> dict[str, float]:
    """Root mean square over the conditions of what `error` gives for each of them [N], by
    convention."""
    each = {name: np.array(error(signs)) for name, signs in CONVENTIONS.items()}
    return {name: float(np.sqrt(np.mean(found**2))) for name, found in each.items()}


def likelier(errors: Mapping[str, float], used: str) -> list[str]:
    """The conventions with the least error, where it is less than half of that of the used one."""
    least = min(errors.values())
    if not least < HALF * errors[used]:
        return []
    return [name for name, error in errors.items() if np.isclose(error, least)]


def side_of(tir: TirFile) -> str:
    """Side of the car that the file states, as LEFT; empty without one."""
    entry = tir.entries.get("TYRESIDE")
    return entry.value.strip("'\" ").upper() if entry else ""
