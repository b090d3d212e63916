# SPDX-License-Identifier: Apache-2.0
"""The measurement table: one row per sample, SI columns, forces at the contact point in ISO W."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from flatplank_data.errors import FlatplankError
from flatplank_data.run_record import RunRecord

#: the columns of a measurement table and their units
STANDARD_COLUMNS: Mapping[str, str] = MappingProxyType(
    {
        "time": "s",
        "plank_position": "m",
        "plank_velocity": "m/s",
        "wheel_angle": "rad",
        "wheel_velocity": "rad/s",
        "motor_velocity": "rad/s",
        "motor_torque": "N m",
        "fx": "N",
        "fy": "N",
        "fz": "N",
        "mx": "N m",
        "my": "N m",
        "mz": "N m",
        "loaded_radius": "m",
        "motion_trigger": "1",
    }
)

#: optional columns and their units
OPTIONAL_COLUMNS: Mapping[str, str] = MappingProxyType(
    {
        "steer_angle": "rad",
        "road_camber": "rad",
        "total_camber": "rad",
        "road_position": "m",
        "slip_reference": "1",
        "slip_actual": "1",
        "slip_start": "m",
        "slip_radius": "m",
        "controller_error": "N",
        "side_slip_angle": "rad",
        "camber_angle": "rad",
        "pressure": "Pa",
        "half_length": "m",
        "half_width": "m",
        "cycle": "1",
        "drive_state": "1",
        "stop_reason": "1",
    }
)

COLUMN_UNITS: Mapping[str, str] = MappingProxyType({**STANDARD_COLUMNS, **OPTIONAL_COLUMNS})


@dataclass(frozen=True)
class MeasurementTable:
    """Columns of one run as float64 arrays of shape (samples,), and its run record."""

    columns: Mapping[str, np.ndarray]
    info: RunRecord = dataclasses.field(default_factory=RunRecord)

    def __post_init__(self) -> None:
        arrays = {}
        rows = None
        for name, values in self.columns.items():
            array = np.atleast_1d(np.asarray(values, dtype=np.float64)).view()
            array.setflags(write=False)
            rows = array.size if rows is None else rows
            if array.ndim != 1 or array.size != rows:
                raise FlatplankError(
                    f"column '{name}' has shape {array.shape}, the others {rows} rows",
                    self.info.file,
                    "give every column the same number of rows",
                )
            arrays[name] = array
        object.__setattr__(self, "columns", MappingProxyType(arrays))

    def __reduce__(self) -> tuple[type[MeasurementTable], tuple[dict[str, np.ndarray], RunRecord]]:
        return MeasurementTable, (dict(self.columns), self.info)

    def __len__(self) -> int:
        return next((array.size for array in self.columns.values()), 0)

    def __contains__(self, name: str) -> bool:
        return name in self.columns

    def __getitem__(self, name: str) -> np.ndarray:
        """Column `name`, shape (samples,), read-only."""
        try:
            return self.columns[name]
        except KeyError:
            raise FlatplankError(
                f"no column '{name}'",
                self.info.file,
                f"add it, or map a foreign name to it; the file has {', '.join(self.columns)}",
            ) from None

    def get(self, name: str) -> np.ndarray:
        """Column `name`, or NaN of the same length where it was not measured."""
        values = self.columns.get(name)
        return np.full(len(self), np.nan) if values is None else values

    def has(self, name: str) -> bool:
        """True when `name` holds at least one measured value."""
        values = self.columns.get(name)
        return values is not None and bool(np.isfinite(values).any())

    @property
    def units(self) -> dict[str, str]:
        """SI unit of every column."""
        return {name: COLUMN_UNITS.get(name, "1") for name in self.columns}

    def select(self, names: Iterable[str]) -> MeasurementTable:
        """The table with these columns only."""
        return MeasurementTable({name: self[name] for name in names}, self.info)

    def rows(self, mask: np.ndarray | slice) -> MeasurementTable:
        """The table with the samples of a mask or slice only."""
        return MeasurementTable({k: v[mask] for k, v in self.columns.items()}, self.info)

    def with_columns(self, **columns: np.ndarray) -> MeasurementTable:
        """The table with columns added or replaced."""
        return MeasurementTable({**self.columns, **columns}, self.info)

    def with_info(self, **changes: Any) -> MeasurementTable:
        """The table with changes in its run record."""
        return MeasurementTable(self.columns, dataclasses.replace(self.info, **changes))
