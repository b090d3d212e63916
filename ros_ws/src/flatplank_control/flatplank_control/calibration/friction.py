# SPDX-License-Identifier: Apache-2.0
"""Friction torque of the wheel drive over motor speed (figures 5.3, 5.11): the torque that turns
the unloaded wheel at constant speeds."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from flatplank_analysis.steady.transmission import (
    TURN_COLUMNS,
    FrictionTorque,
    friction_torque,
)
from flatplank_data.campaign import Run
from flatplank_data.errors import FlatplankError
from flatplank_data.run_record import RunRecord
from flatplank_data.store import open_store
from flatplank_data.table import MeasurementTable


def turns_of(path: Path) -> MeasurementTable:
    """Speed and torque of the motor in a bag or table."""
    return Run(RunRecord(file=path.name), open_store(path.parent)).table(list(TURN_COLUMNS))


def friction_of(tables: Iterable[MeasurementTable]) -> FrictionTorque:
    """Friction torque over motor speed, from the parts of the runs with a constant speed.

    FlatplankError when no part has one.
    """
    found = friction_torque(tables)
    if not (found.torque > 0.0).all():
        what = "the motor needs no torque at a constant speed"
        raise FlatplankError(what, "friction", "record unloaded turns with the drive enabled")
    return found
