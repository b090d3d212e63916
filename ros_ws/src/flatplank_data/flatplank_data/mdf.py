# SPDX-License-Identifier: Apache-2.0
"""MDF4 (ASAM MDF 4.1), the format of measurement in vehicle tests; needs the package asammdf.

One channel group per run: `time` is its master, every other column a channel with unit and
comment. The run record is attached as `run.json`; operator, tire and condition are in the header.
"""

from __future__ import annotations

import gc
import importlib
import io
import json
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from datetime import datetime, timezone
from importlib.metadata import version
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from flatplank_data.errors import FlatplankError
from flatplank_data.table import MeasurementTable

VERSION = "4.10"
RECORD = "run.json"
"""name of the attachment with the run record"""
MASTER = "time"
TEXTS: Mapping[str, str] = {
    "plank_position": "travel of the road plate",
    "plank_velocity": "velocity of the road plate",
    "wheel_angle": "turned angle of the wheel",
    "wheel_velocity": "angular velocity of the wheel",
    "motor_velocity": "angular velocity of the wheel motor",
    "motor_torque": "torque of the wheel motor",
    "fx": "longitudinal force of the road on the tire, ISO W, at the contact point",
    "fy": "lateral force of the road on the tire, ISO W, at the contact point",
    "fz": "vertical force of the road on the tire, ISO W, at the contact point",
    "mx": "overturning moment, ISO W, at the contact point",
    "my": "rolling resistance moment, ISO W, at the contact point",
    "mz": "aligning moment, ISO W, at the contact point",
    "loaded_radius": "height of the wheel centre above the road",
    "motion_trigger": "motion trigger of the road plate, 0 or 1",
    "steer_angle": "steering angle of the wheel",
    "road_camber": "camber of the road",
    "total_camber": "camber of the wheel to the road",
    "road_position": "position by the second encoder of the road",
    "slip_reference": "slip that was asked for, driving > 0",
    "slip_actual": "slip that was reached, driving > 0",
    "slip_start": "travel at which the slip began",
    "slip_radius": "rolling radius that the slip control used",
    "controller_error": "Fx that the control of free rolling leaves",
    "side_slip_angle": "side slip angle, ISO W",
    "camber_angle": "camber angle, ISO W",
    "pressure": "inflation pressure",
    "half_length": "half contact length",
    "half_width": "half contact width",
    "cycle": "number of the bus cycle",
    "drive_state": "state of the wheel drive",
    "stop_reason": "number of the reason of a stop",
}
"""column -> comment of its channel"""
EPOCH = datetime(1970, 1, 1, tzinfo=timezone.utc)
"""start of a recording whose record has no date"""


def asammdf(where: str) -> Any:
    """The package; FlatplankError when it is absent."""
    try:
        return importlib.import_module("asammdf")
    except ImportError as error:
        what = "MDF4 needs the package asammdf (LGPL), which is an extra"
        raise FlatplankError(what, where, "pip install asammdf") from error


def write_mdf4(table: MeasurementTable, path: Path) -> None:
    """Write float64 channels over their times, with units, comments, and the run record."""
    package = asammdf(str(path))
    info, units = table.info, table.units
    if MASTER not in table:
        what = "no column 'time', over which the channels of an MDF4 file are"
        raise FlatplankError(what, info.file or str(path), "measure it, or export another format")
    times = table[MASTER]
    channels = [
        package.Signal(values, times, name=name, unit=units[name], comment=TEXTS.get(name, ""))
        for name, values in table.columns.items()
        if name != MASTER
    ]
    with package.MDF(version=VERSION) as file:
        header = file.header
        header.start_time = _begun(info.started or info.date)
        header.author, header.subject = info.operator, info.tire
        header.project = "flat plank"
        header.description = "; ".join(
            [f"{info.name}: {info.kind}, {info.condition.label()}", *info.notes.splitlines()]
            + [f"made by flatplank_data {version('flatplank_data')}"]
        )
        file.append(channels, comment=info.name, common_timebase=True)
        record = json.dumps(info.to_dict(), default=str).encode()
        file.attach(record, file_name=RECORD, mime="application/json", comment="run record")
        file.save(path, overwrite=True, compression=2)


def _begun(date: str) -> datetime:
    try:
        found = datetime.fromisoformat(date.replace("Z", "+00:00"))
    except ValueError:
        return EPOCH
    return found if found.tzinfo else found.replace(tzinfo=timezone.utc)


@contextmanager
def opened(stream: BinaryIO, where: str) -> Iterator[Any]:
    """The file of asammdf; whatever it raises on a damaged file becomes FlatplankError."""
    with _parsed(asammdf(where), stream.read(), where) as file:
        if file.version < "4":
            what = f"MDF {file.version}, which is older than 4"
            raise FlatplankError(what, where, "convert it to MDF 4")
        try:
            yield file
        except FlatplankError:
            raise
        except Exception as error:  # asammdf raises what its parts raise
            raise _damaged(error, where) from error


def _parsed(package: Any, data: bytes, where: str) -> Any:
    """The file of asammdf. Its destructor fails for a file that it could not open: not told."""
    hook, sys.unraisablehook = sys.unraisablehook, lambda _told: None
    try:
        try:
            return package.MDF(io.BytesIO(data))
        except Exception as error:
            fault = _damaged(error, where)
        gc.collect()
    finally:
        sys.unraisablehook = hook
    raise fault


def _damaged(error: Exception, where: str) -> FlatplankError:
    said = str(error) or type(error).__name__
    return FlatplankError(f"not a whole MDF4 file ({said})", where, "export or copy it again")


def record_in(file: Any) -> dict[str, Any]:
    """The run record that is attached to our own exports; empty for others."""
    for index, block in enumerate(file.attachments):
        if Path(block.file_name).name == RECORD:
            found = json.loads(file.extract_attachment(index=index)[0])
            return found if isinstance(found, dict) else {}
    return {}


def channels_of(file: Any, group: int) -> dict[str, int]:
    """Name -> index of the channels of a group, without its master."""
    master = file.masters_db.get(group)
    found = enumerate(file.groups[group].channels)
    return {channel.name: i for i, channel in found if i != master}


def master_of(file: Any, group: int) -> np.ndarray:
    """Times of a group [s], float64."""
    return np.asarray(file.get_master(group), np.float64)
