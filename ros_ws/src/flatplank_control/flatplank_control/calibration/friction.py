# SPDX-License-Identifier: Apache-2.0
"""Friction torque of the wheel drive over motor speed (figures 5.3, 5.11): the torque that turns
the unloaded wheel at constant speeds."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from flatplank_analysis.steady.transmission import FrictionTorque, friction_torque
from flatplank_data.campaign import Run
from flatplank_data.errors import FlatplankError
from flatplank_data.run_record import RunRecord
from flatplank_data.store import open_store
from flatplank_data.table import MeasurementTable

MOTOR_INERTIA = 0.00126
"""J_M of Table 5.1 [kg m2]"""
INERTIA_SHARE = 0.01
"""largest torque of the inertia in a sample, over that of the friction [-]"""
WINDOW = 0.2
"""time over which a speed must be constant [s]"""
COLUMNS = ["time", "motor_velocity", "motor_torque"]


def turns_of(path: Path) -> MeasurementTable:
    """Speed and torque of the motor in a bag or table."""
    return Run(RunRecord(file=path.name), open_store(path.parent)).table(COLUMNS)


def friction_of(tables: Iterable[MeasurementTable]) -> FrictionTorque:
    """Friction torque over motor speed, from the parts of the runs with a constant speed.

    FlatplankError when no part has one.
    """
    found = friction_torque([_steady(table) for table in tables])
    if not (found.torque > 0.0).all():
        what = "the motor needs no torque at a constant speed"
        raise FlatplankError(what, "friction", "record unloaded turns with the drive enabled")
    return found


def _steady(table: MeasurementTable) -> MeasurementTable:
    time, speed, torque = (table[name] for name in COLUMNS)
    ahead = np.minimum(np.searchsorted(time, time + WINDOW), len(time) - 1)
    behind = np.searchsorted(time, time - WINDOW)
    change = np.maximum(abs(speed[ahead] - speed), abs(speed - speed[behind])) / WINDOW
    keep = (change * MOTOR_INERTIA < INERTIA_SHARE * abs(torque)) & (abs(speed) > 1.0)
    columns = {"motor_velocity": abs(speed[keep]), "motor_torque": abs(torque[keep])}
    if keep.sum() < 5:
        what = "the motor never turns at a constant speed"
        raise FlatplankError(what, table.info.file, "record turns in the mode velocity")
    return MeasurementTable(columns, table.info)
