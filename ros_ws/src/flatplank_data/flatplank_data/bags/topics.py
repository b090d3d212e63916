# SPDX-License-Identifier: Apache-2.0
"""Maps message members to table columns; a mapping file does so for bags of other benches.

Mapping file (YAML)::

    time: header.stamp              # or log_time
    base: /my/encoder               # its samples are the rows of the table
    topics:
      /my/encoder:
        plank_position: {field: position, unit: mm}
        wheel_velocity: omega
      /my/hub:
        fx: {field: wrench.force.x, factor: -1.0}
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from flatplank_data.errors import FlatplankError
from flatplank_data.table import COLUMN_UNITS
from flatplank_data.units import factor_offset

RUN_TOPIC = "/run"
WAVEFORM_TOPIC = "/slip_sequencer/waveform"
"""the waveform that was set, as YAML: its name and parameters, where it starts, rolling radius"""
DRIVE_TOPIC = "/wheel_drive/status"
STAMP = "header.stamp"
"""usual path of a stamp"""


@dataclass(frozen=True)
class Source:
    """Message member that fills a column; value * factor + offset is in SI."""

    column: str
    path: str
    factor: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class TopicMap:
    """Topics to columns."""

    sources: Mapping[str, tuple[Source, ...]]
    base: str
    """topic whose samples are the rows of the table"""
    time: str = STAMP


_ENCODERS = (
    "plank_position",
    "plank_velocity",
    "wheel_angle",
    "wheel_velocity",
    "motor_velocity",
    "steer_angle",
    "road_camber",
    "road_position",
)

OWN = TopicMap(
    {
        "/encoders/state": (
            *(Source(name, name) for name in _ENCODERS),
            Source("motion_trigger", "trigger"),
        ),
        "/measurement_hub/wrench_contact": tuple(
            Source(f"{letter}{axis}", f"wrench.{part}.{axis}")
            for letter, part in (("f", "force"), ("m", "torque"))
            for axis in "xyz"
        ),
        "/measurement_hub/state": (
            Source("loaded_radius", "loaded_radius"),
            Source("total_camber", "total_camber"),
        ),
        DRIVE_TOPIC: (
            Source("motor_torque", "torque"),
            Source("drive_state", "state"),
            Source("stop_reason", "stop_reason"),
        ),
        "/slip_sequencer/state": (
            Source("slip_reference", "reference_slip"),
            Source("slip_actual", "actual_slip"),
            Source("slip_start", "start_position"),
            Source("slip_radius", "effective_rolling_radius"),
        ),
        "/free_rolling_controller/state": (Source("controller_error", "error"),),
    },
    base="/encoders/state",
)


def topic_map(mapping: Mapping[str, Any] | None) -> TopicMap:
    """Our own topics, or those of a mapping file."""
    mapping = mapping or {}
    topics = mapping.get("topics")
    if not topics:
        return OWN
    sources = {
        topic: tuple(_source(topic, column, entry) for column, entry in columns.items())
        for topic, columns in topics.items()
    }
    base = mapping.get("base") or next(
        (t for t, s in sources.items() if any(x.column == "plank_position" for x in s)),
        next(iter(sources)),
    )
    if base not in sources:
        raise FlatplankError(
            f"base topic '{base}' has no columns", "mapping", "name one in topics"
        )
    return TopicMap(sources, base, str(mapping.get("time", STAMP)))


def _source(topic: str, column: str, entry: Any) -> Source:
    where = f"mapping, {topic}, {column}"
    if column not in COLUMN_UNITS:
        known = ", ".join(COLUMN_UNITS)
        raise FlatplankError(f"unknown column '{column}'", where, f"use one of {known}")
    if isinstance(entry, str):
        return Source(column, entry)
    unknown = set(entry) - {"field", "unit", "factor"}
    if unknown or "field" not in entry:
        what = f"unknown key '{sorted(unknown)[0]}'" if unknown else "no 'field'"
        raise FlatplankError(what, where, "keys are field, unit, factor")
    factor, offset = 1.0, 0.0
    if "unit" in entry:
        factor, offset = factor_offset(str(entry["unit"]), COLUMN_UNITS[column], where)
    sign = float(entry.get("factor", 1.0))
    return Source(column, str(entry["field"]), sign * factor, sign * offset)
