# SPDX-License-Identifier: Apache-2.0
"""Axis systems of tire data: found by physics, said, and turned into ISO W.

A loaded tire is pressed upwards, and a tire that slides to one side is pushed to the other. Of the
systems in use (Pacejka, Tire and Vehicle Dynamics, 2012, appendix 1) each has signs of its own for
the two.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from flatplank_data.errors import FlatplankError

UP = 0.05
"""share of the largest load: below it the tire is not loaded [-]"""
SMALL_ALPHA, SMALL_KAPPA = 0.03, 0.03
"""slip within which forces are in proportion [rad, -]"""
LEAST = 20
"""samples for a slope"""
CERTAIN = 0.3
"""correlation of force and slip below which their sign says nothing"""


class System(NamedTuple):
    """Signs of a system, and which channels turn on the way to ISO W."""

    title: str
    load: int
    """sign of Fz of a loaded tire"""
    side: int
    """sign of dFy / dalpha"""
    turned: tuple[str, ...]


SYSTEMS = {
    "iso": System("ISO W (ISO 8855: z up, y to the left)", 1, -1, ()),
    "sae": System(
        "SAE J670 (z down, y to the right)", -1, -1, ("alpha", "fy", "fz", "my", "mz")
    ),
    "adapted": System(
        "adapted SAE (z down, y to the right, load and slip angle turned)",
        1, 1, ("fy", "my", "mz"),
    ),
}  # fmt: skip


class Axes(NamedTuple):
    """The system of a file, how it was found, and the columns in ISO W."""

    system: str
    said: str
    columns: dict[str, np.ndarray]


def in_iso(columns: Mapping[str, np.ndarray], wanted: str | None, where: str) -> Axes:
    """Columns in ISO W; `wanted` overrides what physics says.

    Raises:
        FlatplankError: no system has these signs, or the wanted one has others.
    """
    load = int(np.sign(np.median(_loaded(columns["fz"]))))
    side = _slope_sign(columns, "fy", "alpha", SMALL_ALPHA)
    drive = _slope_sign(columns, "fx", "kappa", SMALL_KAPPA)
    if drive < 0:
        raise FlatplankError(
            "Fx falls where the slip rises: a driven tire would brake", where,
            "turn the sign of the column of the slip, or of Fx",
        )  # fmt: skip
    fitting = [
        name
        for name, system in SYSTEMS.items()
        if system.load == load and side in (0, system.side)
    ]
    seen = f"Fz {'< 0' if load < 0 else '> 0'}"
    seen += {1: ", Fy rises with the slip angle", -1: ", Fy falls with the slip angle", 0: ""}[
        side
    ]
    if wanted is not None and wanted not in fitting:
        raise FlatplankError(
            f"the signs are not those of {SYSTEMS[wanted].title}: {seen}", where,
            _advice(fitting),
        )  # fmt: skip
    if not fitting:
        raise FlatplankError(
            f"no axis system has these signs: {seen}", where,
            "turn the sign of the column of the slip angle, or of Fy",
        )  # fmt: skip
    system = wanted or fitting[0]
    turned = SYSTEMS[system].turned
    out = {k: -v if k in turned else v for k, v in columns.items()}
    said = f"axes: {SYSTEMS[system].title}, by {seen}"
    others = [name for name in fitting if name != system]
    if wanted:
        said = f"axes: {SYSTEMS[system].title}, as asked for"
    elif others:
        said += f"; nothing tells it from {' or '.join(others)} (--axes NAME)"
    return Axes(system, said, out)


def _advice(fitting: list[str]) -> str:
    return f"leave --axes out, or say --axes {fitting[0]}" if fitting else "turn a column's sign"


def _loaded(fz: np.ndarray) -> np.ndarray:
    return fz[np.abs(fz) > UP * np.abs(fz).max()]


def _slope_sign(columns: Mapping[str, np.ndarray], force: str, slip: str, small: float) -> int:
    """Of the force over small slip; 0 when the data do not say."""
    if force not in columns or slip not in columns:
        return 0
    near = np.abs(columns[slip]) < small
    x, y = columns[slip][near], columns[force][near]
    if near.sum() < LEAST or np.ptp(x) < 0.2 * small or np.ptp(y) == 0.0:
        return 0
    r = float(np.corrcoef(x, y)[0, 1])
    return int(np.sign(r)) if abs(r) > CERTAIN else 0
