# SPDX-License-Identifier: Apache-2.0
"""Wheel angles that start again after each turn, as those of absolute encoders."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from flatplank_data.errors import FlatplankError

COLUMN = "wheel_angle"
TURNS = {"rad": 2.0 * math.pi, "deg": 360.0, "rev": 1.0}
"""unit -> one turn"""


def whole_turns(
    columns: Mapping[str, np.ndarray], file: str
) -> tuple[dict[str, np.ndarray], list[str]]:
    """The columns with a wheel angle that counts its turns, and a remark where this was changed.

    A jump is a step over more than half of the range of the column. It is one turn where it
    differs from a turn by no more than the wheel turns between two samples.

    Raises:
        FlatplankError: the angle jumps by a turn of another unit, or back by what is no turn.
    """
    angle = columns.get(COLUMN)
    if angle is None or len(angle) < 3 or not np.isfinite(angle).all():
        return dict(columns), []
    step = np.diff(angle)
    jumps = np.abs(step) > 0.5 * np.ptp(angle)
    if not jumps.any() or jumps.sum() * 2 > len(step):
        return dict(columns), []
    row = int(np.argmax(jumps)) + 2
    slack = 2.0 * float(np.abs(step[~jumps]).max())
    unit = next((u for u, turn in TURNS.items() if _are(step[jumps], turn, slack)), None)
    if unit == "rad":
        turns = np.cumsum(np.where(jumps, -np.sign(step), 0.0))
        whole = angle + TURNS["rad"] * np.concatenate([[0.0], turns])
        told = f"column '{COLUMN}' starts again after a turn (row {row}): turns are counted"
        return {**columns, COLUMN: whole}, [told]
    if unit:
        raise FlatplankError(
            f"jumps by {step[row - 2]:.4g}: one turn in {unit}, not in rad",
            f"{file}, row {row}, column '{COLUMN}'", f"write its unit, as '{COLUMN} [{unit}]'",
        )  # fmt: skip
    back = np.sign(step[jumps]) == -np.sign(step[~jumps].sum())
    if back.all() and slack < 0.5 * float(np.abs(step[jumps]).min()):
        raise FlatplankError(
            f"jumps back by {abs(step[row - 2]):.4g} rad, which is no turn",
            f"{file}, row {row}, column '{COLUMN}'", "correct its unit, or repair the samples",
        )  # fmt: skip
    return dict(columns), []


def _are(jumps: np.ndarray, turn: float, slack: float) -> bool:
    """Whether all jumps are one turn, less what the wheel turns meanwhile."""
    return slack < 0.5 * turn and bool((np.abs(np.abs(jumps) - turn) <= slack).all())
