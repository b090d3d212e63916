# SPDX-License-Identifier: Apache-2.0
"""Everything that describes one measurement: said before it starts, closed whatever happens.

The keys are those of a run in `campaign.yaml`, so that a bag's `run.yaml` reads as one.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import Any
from uuid import UUID, uuid4

import yaml

from flatplank_data.errors import RecordingError
from flatplank_data.files import read_text, replace_text
from flatplank_data.limits import IN_FILES
from flatplank_data.naming import MeasurementName, check_name, kind_of
from flatplank_data.params import nearest

FORMAT = "flatplank-run/1"
FILE_NAME = "run.yaml"
STATUSES = (
    "described",
    "armed",
    "recording",
    "complete",
    "stopped",
    "interrupted",
    "failed",
    "discarded",
)


@dataclass(frozen=True)
class RunRecord:
    """One run. Units: m, N, bar, deg where the key says so; slip is ISO, driving > 0."""

    tire: str
    name: str = ""
    """file name, Appendix F; made of the rest when empty"""
    uuid: str = field(default_factory=lambda: str(uuid4()))
    """identity of the run; names may repeat"""
    measurement: str = "slip"
    """slip, free_rolling, stiffness, footprint, unloaded_turn, cleat, ..."""
    kappa: float = 0.0
    """desired slip [-]"""
    fz: float = 0.0
    """nominal vertical force [N]"""
    pressure: float = 0.0
    """[bar]"""
    alpha_deg: float = 0.0
    gamma_deg: float = 0.0
    start: int = 1
    """1, 2, 3: wheel at 0, 120, 240 deg"""
    start_angle_deg: float | None = None
    """wheel angle in place of that of `start`"""
    run_index: int = 0
    """order in which the runs of a campaign were made"""
    repeat: int = 0
    serial: str = ""
    """of the tire"""
    operator: str = ""
    effective_rolling_radius: float | None = None
    """as used by the slip control [m]"""
    r_e_source: str = ""
    """where it comes from: name of the free-rolling run, typed in, ..."""
    waveform: Mapping[str, Any] = field(default_factory=dict)
    step_position: float | None = None
    """plank travel at which the waveform starts [m]"""
    speed: float | None = None
    """of the plank [m/s]"""
    direction: str = "forward"
    et_value: float | None = None
    """[m]"""
    adapter_thickness: float | None = None
    """[m]"""
    wheel_camber_deg: float | None = None
    road_camber_offset_deg: float | None = None
    slip_angle_offset_deg: float | None = None
    calibration: Mapping[str, Any] = field(default_factory=dict)
    """per instrument: date and factors"""
    parameters: Mapping[str, Any] = field(default_factory=dict)
    """of the nodes, as they were at the start"""
    plant: Mapping[str, Any] | None = None
    """simulated bench: preset, seed, ...; none in the lab"""
    software_version: str = ""
    started: str = ""
    """ISO 8601, UTC"""
    ended: str = ""
    status: str = "described"
    cycle_first: int | None = None
    """number of the first bus cycle in the bag"""
    cycle_last: int | None = None
    cycles_received: int = 0
    cycles_lost: int = 0
    """gaps in the cycle numbers or in the stamps"""
    filled_in: list[str] = field(default_factory=list)
    """keys that nobody said, taken from what the nodes said and measured"""
    stop_reason: str = ""
    notes: str = ""

    def __post_init__(self) -> None:
        _validate(self)
        if not self.name:
            object.__setattr__(self, "name", str(measurement_name(self)))
        check_name(self.name)

    def with_changes(self, **changes: Any) -> RunRecord:
        """A copy with other values, checked again; an unknown key names the nearest one."""
        _check_keys(changes, "run record")
        return replace(self, **changes)

    def to_dict(self) -> dict[str, Any]:
        return {"format": FORMAT, **_plain(asdict(self))}

    def to_yaml(self) -> str:
        return yaml.safe_dump(self.to_dict(), sort_keys=False, allow_unicode=True)

    def to_json(self) -> str:
        return json.dumps(self.to_dict(), indent=1)

    def save(self, folder: Path) -> None:
        """`run.yaml` in the bag's folder, replaced in one step."""
        replace_text(folder / FILE_NAME, self.to_yaml())


def _plain(value: Any) -> Any:
    """Numbers of numpy and other containers as what YAML and JSON know."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    return value.tolist() if hasattr(value, "tolist") else value


def measurement_name(record: RunRecord) -> MeasurementName:
    """Name by Appendix F of what the record describes."""
    return MeasurementName(
        tire=record.tire,
        kind=kind_of(
            record.measurement,
            record.alpha_deg,
            record.gamma_deg,
            str((record.waveform or {}).get("name", "")),
        ),
        pressure=record.pressure,
        fz=record.fz,
        start=record.start,
        kappa_percent=record.kappa * 100,
        alpha_deg=record.alpha_deg,
        gamma_deg=record.gamma_deg,
    )


def record_from_dict(data: Mapping[str, Any], where: str = "run record") -> RunRecord:
    """The record in `data`; `where` names the source in an error."""
    if not isinstance(data, Mapping):
        raise RecordingError(f"{where}: not a run record; it must be keys and values")
    values = {key: value for key, value in data.items() if key != "format"}
    if data.get("format", FORMAT) != FORMAT:
        raise RecordingError(f"{where}: format {data['format']!r} is unknown; use {FORMAT!r}")
    _check_keys(values, where)
    if "tire" not in values:
        raise RecordingError(f"{where}: tire is missing; name the tire")
    try:
        return RunRecord(**values)
    except RecordingError as error:
        raise RecordingError(f"{where}: {error}") from None


def record_from_yaml(text: str, where: str = "run record") -> RunRecord:
    try:
        data = yaml.safe_load(text)
    except yaml.YAMLError as error:
        line = getattr(getattr(error, "problem_mark", None), "line", -1) + 1
        raise RecordingError(f"{where}: not YAML (line {line}); correct it") from None
    return record_from_dict(data, where)


def record_from_json(text: str, where: str = "run record") -> RunRecord:
    try:
        data = json.loads(text)
    except json.JSONDecodeError as error:
        raise RecordingError(f"{where}: not JSON (line {error.lineno}); correct it") from None
    return record_from_dict(data, where)


def load_record(folder: Path) -> RunRecord:
    """The record beside a bag."""
    path = folder / FILE_NAME
    try:
        text = read_text(path)
    except ValueError as error:
        raise RecordingError(str(error)) from None
    return record_from_yaml(text, str(path))


_KEYS = {item.name: item for item in fields(RunRecord)}


def _check_keys(values: Mapping[str, Any], where: str) -> None:
    for key in values:
        if key not in _KEYS:
            raise RecordingError(f"{where}: unknown key {key!r}{nearest(key, _KEYS)}")


_TEXTS = ("tire", "name", "uuid", "measurement", "serial", "operator", "status", "notes")


def _validate(record: RunRecord) -> None:
    for key in _TEXTS:
        if not isinstance(getattr(record, key), str):
            raise RecordingError(f"{key} is {getattr(record, key)!r}; it must be text")
    for key, limit in IN_FILES.items():
        value = getattr(record, key)
        if value is None and _KEYS[key].default is None:
            continue
        number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if not number or not math.isfinite(value) or not limit.low <= value <= limit.high:
            span = f"{limit.low:g} to {limit.high:g} [{limit.unit or '-'}]"
            raise RecordingError(f"{key} is {value!r}; it must be {span}")
    if not record.tire:
        raise RecordingError("tire is empty; name the tire, for example TOY")
    if record.status not in STATUSES:
        raise RecordingError(f"status {record.status!r} is unknown; use {', '.join(STATUSES)}")
    try:
        UUID(record.uuid)
    except ValueError:
        raise RecordingError(f"uuid {record.uuid!r} is none; leave it out to get one") from None
