# SPDX-License-Identifier: Apache-2.0
"""What describes one run: the fields of `campaign.yaml`, the same whatever the file format."""

from __future__ import annotations

import dataclasses
import difflib
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from flatplank_data.errors import FlatplankError

STEPS = ("step", "constant")
"""waveforms that hold one slip to the end of the run"""


SLOW_BELOW = 0.01
"""a run at a plank speed below this one is no repeat of one at the usual speed [m/s]"""


class Condition(NamedTuple):
    """What a tire test holds constant; runs with the same condition are repeats."""

    tire: str
    measurement: str
    fz: float
    """nominal load [N]"""
    pressure: float
    """[bar]"""
    alpha_deg: float
    gamma_deg: float
    kappa: float
    """desired slip [-]; NaN in an operating point"""

    def __reduce__(self) -> tuple:
        # NaN equals only itself: what comes from another process must have the same object
        return _condition, tuple(self)

    @property
    def operating_point(self) -> Condition:
        """The same without the slip level: what one carcass stiffness is fitted to."""
        return self._replace(kappa=math.nan)

    @property
    def sort_key(self) -> tuple:
        """For sorting; NaN comes first."""
        return tuple(-math.inf if value != value else value for value in self)

    def label(self) -> str:
        """Short text for tables and figures."""
        bar = f"{self.pressure:g} bar" if self.pressure > 0.0 else "pressure not said"
        text = f"Fz {self.fz:g} N, {bar}"
        if self.alpha_deg and not math.isnan(self.alpha_deg):
            text += f", α {self.alpha_deg:g}°"
        if self.gamma_deg:
            text += f", γ {self.gamma_deg:g}°"
        if not math.isnan(self.kappa):
            text = f"κ {100.0 * self.kappa:+g} %, " + text
        return text


def _condition(tire: str, measurement: str, *numbers: float) -> Condition:
    """A condition with one NaN object, so that those without a value meet as dictionary keys."""
    return Condition(tire, measurement, *(math.nan if v != v else v for v in numbers))


@dataclass(frozen=True)
class RunInfo:
    """Run record of one measurement; SI except where the name says otherwise."""

    file: str = ""
    tire: str = ""
    measurement: str = "slip"
    kappa: float = 0.0
    """desired slip [-], ISO sign: driving > 0"""
    fz: float = math.nan
    """nominal load [N]"""
    pressure: float = math.nan
    """[bar]"""
    alpha_deg: float = 0.0
    gamma_deg: float = 0.0
    start: int = 1
    """1, 2, 3 = wheel started at 0, 120, 240 deg"""
    start_angle_deg: float = math.nan
    """wheel angle in place of that of `start`"""
    run_index: int = 0
    """order in which the runs were made"""
    effective_rolling_radius: float = math.nan
    """as used by the slip control [m]"""
    step_position: float = math.nan
    """plank travel at which the step was commanded [m]"""
    repeat: int = 1
    speed: float = math.nan
    """commanded plank speed [m/s]"""
    direction: float = 1.0
    """+1 forward, -1 reversed"""
    waveform: Mapping[str, Any] | None = None
    et_value: float = math.nan
    """[m]"""
    adapter_thickness: float = math.nan
    """[m]"""
    wheel_camber_deg: float = math.nan
    r_e_source: str = ""
    """controller, slip_control, flexplates_off"""
    uuid: str = ""
    operator: str = ""
    date: str = ""
    software_version: str = ""
    status: str = ""
    notes: str = ""
    cycles_received: int = 0
    cycles_lost: int = 0
    """as the recorder counted them, over the whole recording"""
    extra: Mapping[str, Any] = field(default_factory=dict, compare=False)
    """keys that this version does not know"""

    @property
    def kind(self) -> str:
        """The measurement, with the waveform when that is no step, direction and slow speed."""
        name = str((self.waveform or {}).get("name", "step"))
        words = [self.measurement]
        if self.measurement == "slip" and name not in STEPS:
            words.append(name)
        if self.direction < 0.0:
            words.append("reversed")
        if self.speed < SLOW_BELOW:
            words.append("slow")
        return " ".join(words)

    @property
    def start_angle(self) -> float:
        """Wheel angle at the start [rad]."""
        given = self.start_angle_deg
        return math.radians(120.0 * (self.start - 1) if math.isnan(given) else given)

    @property
    def is_step(self) -> bool:
        """A slip step, forward: what the step models are fitted to."""
        return self.kind == "slip"

    @property
    def condition(self) -> Condition:
        """Key of the repeats of this run."""
        numbers = (self.fz, self.pressure, self.alpha_deg, self.gamma_deg, self.kappa)
        return _condition(self.tire, self.kind, *numbers)

    @property
    def name(self) -> str:
        """File name without folder and suffix."""
        return stem_of(self.file)

    def to_dict(self) -> dict[str, Any]:
        """Plain values that differ from the defaults, for YAML."""
        out = {}
        for item in dataclasses.fields(self):
            value = getattr(self, item.name)
            if item.name == "extra" or value is None or _is_nan(value):
                continue
            if value != item.default or item.name in _ALWAYS:
                out[item.name] = value
        return out | dict(self.extra)


UNITS: Mapping[str, str] = {
    "kappa": "1", "fz": "N", "pressure": "bar", "alpha_deg": "deg", "gamma_deg": "deg",
    "start_angle_deg": "deg", "effective_rolling_radius": "m", "step_position": "m",
    "speed": "m/s", "et_value": "m", "adapter_thickness": "m", "wheel_camber_deg": "deg",
}  # fmt: skip
"""of the fields that have one"""


def stem_of(file: str) -> str:
    """A file or bag without folder and suffix."""
    stem = file.rstrip("/").rsplit("/", 1)[-1]
    for suffix in KNOWN_SUFFIXES:
        if stem.lower().endswith(suffix):
            stem = stem[: -len(suffix)]
    return stem


KNOWN_SUFFIXES = (".zstd", ".parquet", ".csv", ".mat", ".tdx", ".tydex", ".mcap", ".db3")
_ALWAYS = {"file", "tire", "kappa", "fz", "pressure", "alpha_deg", "gamma_deg", "start"}
_RECORD_ONLY = {
    "format",
    "name",
    "filled_in",
    "serial",
    "calibration",
    "parameters",
    "plant",
    "started",
    "ended",
    "stop_reason",
    "road_camber_offset_deg",
    "slip_angle_offset_deg",
    "cycle_first",
    "cycle_last",
}
"""keys of the bench's run record that the analysis only keeps"""
_DIRECTIONS = {"forward": 1.0, "reverse": -1.0, "reversed": -1.0, "backward": -1.0}
_FIELDS = {item.name: item for item in dataclasses.fields(RunInfo) if item.name != "extra"}


def _is_nan(value: Any) -> bool:
    return isinstance(value, float) and math.isnan(value)


def info_from_dict(raw: Mapping[str, Any], where: str) -> tuple[RunInfo, list[str]]:
    """Build a run record; returns it with remarks on keys that look misspelt.

    Unknown keys are kept in `extra`: a newer bench may write more than this version knows.
    """
    known: dict[str, Any] = {}
    extra: dict[str, Any] = {}
    remarks = []
    for key, value in raw.items():
        if key in _FIELDS:
            known[key] = _convert(key, value, where)
            continue
        extra[str(key)] = value
        if key in _RECORD_ONLY:
            continue
        near = difflib.get_close_matches(str(key), _FIELDS, n=1, cutoff=0.75)
        if near:
            remarks.append(f"unknown key '{key}' (nearest: '{near[0]}')")
    return RunInfo(**known, extra=extra), remarks


def _convert(key: str, value: Any, where: str) -> Any:
    kind = str(_FIELDS[key].type)
    if value is None:
        return _FIELDS[key].default
    if key == "direction" and str(value) in _DIRECTIONS:
        return _DIRECTIONS[str(value)]
    try:
        if key == "pressure" and not float(value):
            return math.nan  # nobody measures it: a record that was not told has none
        if kind == "float":
            return float(value)
        if kind == "int":
            return int(value)
    except (TypeError, ValueError) as error:
        remedy = "write one number" if kind == "float" else "write one whole number"
        raise FlatplankError(f"'{key}: {value}' is not a number", where, remedy) from error
    return str(value) if kind == "str" else value
