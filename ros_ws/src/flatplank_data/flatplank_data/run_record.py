# SPDX-License-Identifier: Apache-2.0
"""The run record: everything that describes one measurement, from any bench and file format.

The keys are those of a run in `campaign.yaml`; `run.yaml` of a bag has the same. For its own
records the bench refuses unknown keys (`record_from_dict`); foreign files are read as far as
possible (`read_run`).
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import Any
from uuid import uuid4

from flatplank_data.condition import Condition, condition_of, is_nan
from flatplank_data.errors import FlatplankError, RecordingError, YamlError
from flatplank_data.files import read_text, write_atomic
from flatplank_data.names import similar_names
from flatplank_data.naming import STEPS, check_name, name_of
from flatplank_data.record_checks import STATUSES, check_keys, check_values, converted, default_of
from flatplank_data.yaml_text import dump_yaml, load_yaml

FORMAT = "flatplank-run/1"
FILE_NAME = "run.yaml"
SLOW_BELOW = 0.01
"""runs at a plank speed below this are a kind of their own, no repeats of usual ones [m/s]"""
KNOWN_SUFFIXES = (
    ".zstd", ".parquet", ".csv", ".mat", ".tdx", ".tydex", ".mf4", ".mcap", ".db3", ".bag",
)  # fmt: skip
"""suffixes of files with samples, lower case; that of a compressed file first"""


@dataclass(frozen=True)
class RunRecord:
    """One run. Units: m, N, bar, deg where the key says so; NaN: unknown."""

    file: str = ""
    """file of the samples, in the folder of the campaign"""
    tire: str = ""
    name: str = ""
    """file name without folder and suffix; before there is a file, the name by Appendix F"""
    uuid: str = ""
    """unique identity of the run; names need not be unique"""
    measurement: str = "slip"
    """slip, free_rolling, stiffness, footprint, unloaded_turn, cleat, ..."""
    kappa: float = 0.0
    """desired slip [-], ISO sign: driving > 0"""
    fz: float = math.nan
    """nominal load [N]"""
    pressure: float = math.nan
    """inflation pressure [bar]"""
    alpha_deg: float = 0.0
    """side slip angle, ISO W"""
    gamma_deg: float = 0.0
    """camber, ISO W"""
    start: int = 1
    """1, 2, 3: wheel starts at 0, 120, 240 deg"""
    start_angle_deg: float = math.nan
    """wheel angle that overrides that of `start`"""
    run_index: int = 0
    """order in which the runs of a campaign were made"""
    repeat: int = 1
    serial: str = ""
    """serial number of the tire"""
    operator: str = ""
    effective_rolling_radius: float = math.nan
    """radius that the slip control used [m]"""
    r_e_source: str = ""
    """origin of the radius: name of the free-rolling run, typed in, ..."""
    waveform: Mapping[str, Any] | None = None
    step_position: float = math.nan
    """plank travel at which the waveform starts [m]"""
    speed: float = math.nan
    """commanded speed of the plank [m/s]"""
    direction: float = 1.0
    """+1 forward, -1 reverse"""
    et_value: float = math.nan
    """offset of the rim (ET) [m]"""
    adapter_thickness: float = math.nan
    """thickness of the adapter [m]"""
    wheel_camber_deg: float = math.nan
    road_camber_offset_deg: float = math.nan
    slip_angle_offset_deg: float = math.nan
    calibration: Mapping[str, Any] = field(default_factory=dict)
    """instrument -> date and factors"""
    parameters: Mapping[str, Any] = field(default_factory=dict)
    """parameters of the nodes at the start of the run"""
    plant: Mapping[str, Any] | None = None
    """preset, seed, ... of a simulated bench; None in the lab"""
    software_version: str = ""
    date: str = ""
    started: str = ""
    """ISO 8601, UTC"""
    ended: str = ""
    status: str = ""
    cycle_first: int | None = None
    """number of the first bus cycle in the bag"""
    cycle_last: int | None = None
    cycles_received: int = 0
    cycles_lost: int = 0
    """cycles missing by their numbers or stamps, over the whole recording"""
    cycles_late: int | None = None
    """cycles that the bus made later than the next ones were due; None: not in real time"""
    filled_in: list[str] = field(default_factory=list)
    """keys that the recorder filled in from messages and samples"""
    stop_reason: str = ""
    notes: str = ""
    extra: Mapping[str, Any] = field(default_factory=dict, compare=False)
    """unknown keys, kept unchanged"""

    def __post_init__(self) -> None:
        if self.file:
            object.__setattr__(self, "name", stem_of(self.file))

    @property
    def kind(self) -> str:
        """The measurement, with the waveform unless it is a step, and marks for reverse and slow
        runs."""
        name = str((self.waveform or {}).get("name", ""))
        words = [self.measurement]
        if self.measurement == "slip" and name not in STEPS:
            words.append(name)
        if self.direction < 0.0:
            words.append("reversed")
        if self.speed < SLOW_BELOW:
            words.append("slow")
        return " ".join(words)

    @property
    def bench(self) -> str:
        """The key `bench` of the record where it has one; else the preset of a simulated bench."""
        said = self.extra.get("bench")
        if said or not self.plant:
            return str(said or "")
        return f"simulated {self.plant.get('preset') or ''}".strip()

    @property
    def day(self) -> str:
        """Day of the measurement: '2026-05-01'; empty when the record has none."""
        return str(self.date or self.started)[:10]

    @property
    def start_angle(self) -> float:
        """Wheel angle at the start [rad]."""
        given = self.start_angle_deg
        return math.radians(120.0 * (self.start - 1) if math.isnan(given) else given)

    @property
    def is_step(self) -> bool:
        """True for a forward slip step, to which the step models are fitted."""
        return self.kind == "slip"

    @property
    def condition(self) -> Condition:
        """Test condition, by which repeats are grouped."""
        numbers = (self.fz, self.pressure, self.alpha_deg, self.gamma_deg, self.kappa)
        return condition_of(self.tire, self.kind, *numbers)

    def with_changes(self, **changes: Any) -> RunRecord:
        """A copy with other values, checked; an error for an unknown key names the nearest one."""
        check_keys(changes, _OWN, "run record")
        return _checked(self, changes)

    def to_dict(self) -> dict[str, Any]:
        """Plain values that differ from the defaults, for a run in `campaign.yaml`."""
        out = {}
        for item in _KEYS.values():
            value = getattr(self, item.name)
            if value is None or is_nan(value) or (item.name == "name" and self.file):
                continue
            if value != default_of(item) or item.name in _ALWAYS:
                out[item.name] = value
        return {**out, **self.extra}

    def to_yaml(self) -> str:
        """The text of `run.yaml`, with every key."""
        return dump_yaml(self._whole(), allow_unicode=True)

    def _whole(self) -> dict[str, Any]:
        values = {key: getattr(self, key) for key in _OWN}
        unset = {key: 0.0 for key in ("fz", "pressure") if is_nan(values[key])}
        way = "reverse" if self.direction < 0.0 else "forward"
        return _plain({"format": FORMAT, **values, **unset, "direction": way})

    def save(self, folder: Path) -> None:
        """Write `run.yaml` to the bag's folder, atomically."""
        write_atomic(folder / FILE_NAME, self.to_yaml(), durable=False)


_KEYS = {item.name: item for item in dataclasses.fields(RunRecord) if item.name != "extra"}
_OWN = {key: item for key, item in _KEYS.items() if key not in ("file", "date")}
"""keys that a record of this bench may have"""
_ALWAYS = {"file", "tire", "kappa", "fz", "pressure", "alpha_deg", "gamma_deg", "start"}
_BENCH = {"status": STATUSES[0], "waveform": {}}
"""values of every record of this bench before it starts"""
OF_THE_RECORDING = frozenset({
    "name", "serial", "calibration", "parameters", "plant", "started", "ended", "stop_reason",
    "filled_in", "road_camber_offset_deg", "slip_angle_offset_deg", "cycle_first", "cycle_last",
    "cycles_late",
})  # fmt: skip
"""keys that only the recorder of this bench writes"""
UNITS: Mapping[str, str] = {
    "kappa": "1", "fz": "N", "pressure": "bar", "alpha_deg": "deg", "gamma_deg": "deg",
    "start_angle_deg": "deg", "effective_rolling_radius": "m", "step_position": "m",
    "speed": "m/s", "et_value": "m", "adapter_thickness": "m", "wheel_camber_deg": "deg",
}  # fmt: skip
"""key -> unit, for keys with a unit"""


def stem_of(file: str) -> str:
    """Name of a file or bag without folder and suffix."""
    stem = PurePosixPath(file).name
    for suffix in KNOWN_SUFFIXES:
        if stem.lower().endswith(suffix):
            stem = stem[: -len(suffix)]
    return stem


def _plain(value: Any) -> Any:
    """Convert numpy numbers and containers to types of YAML and JSON; NaN becomes null."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    plain = value.tolist() if hasattr(value, "tolist") else value
    return None if is_nan(plain) else plain


def read_run(raw: Mapping[str, Any], where: str) -> tuple[RunRecord, list[str]]:
    """The record in a file from any bench, with remarks on keys that look misspelt.

    Unknown keys are kept in `extra`: a newer bench may write more than this version knows.
    """
    known: dict[str, Any] = {}
    extra: dict[str, Any] = {}
    remarks = []
    for key, value in raw.items():
        if key == "format":
            continue
        if key in _KEYS:
            known[key] = converted(_KEYS[key], value, where)
            continue
        extra[str(key)] = value
        near = similar_names(key, _KEYS, 0.75)
        if near:
            remarks.append(f"unknown key '{key}' (nearest: '{near[0]}')")
    return RunRecord(**known, extra=extra), remarks


def record_from_dict(data: Mapping[str, Any], where: str = "run record") -> RunRecord:
    """A record of this bench with every value checked; `where` names the source in errors."""
    if not isinstance(data, Mapping):
        raise RecordingError(f"{where}: not a run record; it must be keys and values")
    values = {key: value for key, value in data.items() if key != "format"}
    if data.get("format", FORMAT) != FORMAT:
        raise RecordingError(f"{where}: format {data['format']!r} is unknown; use {FORMAT!r}")
    check_keys(values, _OWN, where)
    if "tire" not in values:
        raise RecordingError(f"{where}: tire is missing; name the tire")
    try:
        return _checked(RunRecord(), {"uuid": str(uuid4()), **_BENCH, **values})
    except RecordingError as error:
        raise RecordingError(f"{where}: {error}") from None


def _checked(record: RunRecord, changes: Mapping[str, Any]) -> RunRecord:
    """The record with these values; RecordingError for a value out of range."""
    check_values(changes, _KEYS)
    try:
        own = {key: converted(_KEYS[key], value, key) for key, value in changes.items()}
    except FlatplankError as error:
        raise RecordingError(str(error)) from None
    changed = dataclasses.replace(record, **own)
    if not changed.name:
        return dataclasses.replace(changed, name=name_of(vars(changed)))
    check_name(changed.name)
    return changed


def record_from_yaml(text: str, where: str = "run record") -> RunRecord:
    """The record in a YAML text, checked as by `record_from_dict`."""
    try:
        return record_from_dict(load_yaml(text, where), where)
    except YamlError as error:
        raise RecordingError(str(error)) from None


def load_record(folder: Path) -> RunRecord:
    """The record in the folder of a bag."""
    path = folder / FILE_NAME
    try:
        text = read_text(path)
    except ValueError as error:
        raise RecordingError(str(error)) from None
    return record_from_yaml(text, str(path))
