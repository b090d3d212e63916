# SPDX-License-Identifier: Apache-2.0
"""The calibration book: one file with the calibrations of a bench, their dates, quality and
validity."""

from __future__ import annotations

import datetime
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from flatplank_data.files import write_atomic
from flatplank_data.names import nearest_hint
from flatplank_data.values import is_number
from flatplank_data.yaml_text import dump_yaml, load_format

FORMAT = "flatplank-calibration/1"
FILE = "calibration.yaml"
FRICTION = ("friction_speed", "friction_torque")
"""the only parameters that are tables"""
FIT = "parasitic_fit"
"""the only parameter that is a file; it lies beside the book"""
Value = float | str | list[float]
Constants = Mapping[str, Mapping[str, Any]]
"""node -> parameter -> value"""


class Instrument(NamedTuple):
    """Parameters that are calibrated together."""

    days: int
    """validity of a calibration [days]"""
    parameters: tuple[str, ...]
    nodes: tuple[str, ...]
    """nodes with these parameters"""


HUB, ENCODERS = "measurement_hub", "encoders"
DRIVE, SLIP, FREE = "wheel_drive", "slip_sequencer", "free_rolling_controller"
INSTRUMENTS = {
    "hub_fx": Instrument(730, ("k_fx1", "k_fx2"), (HUB,)),
    "hub_fy": Instrument(730, ("k_fy",), (HUB,)),
    "hub_fz": Instrument(730, ("k_fz1", "k_fz2"), (HUB,)),
    "lvdt": Instrument(365, ("lvdt_gain", "lvdt_offset"), (HUB,)),
    "plank_encoder": Instrument(365, ("pinion_pitch_radius",), (ENCODERS, SLIP)),
    "motor": Instrument(365, ("gear_ratio",), (ENCODERS, HUB, DRIVE, SLIP, FREE)),
    "friction": Instrument(365, FRICTION, (HUB,)),
    "parasitic": Instrument(30, (FIT,), (HUB,)),
}

CALIBRATED = {
    node: tuple(key for i in INSTRUMENTS.values() if node in i.nodes for key in i.parameters)
    for node in dict.fromkeys(node for i in INSTRUMENTS.values() for node in i.nodes)
}
"""node -> all its calibrated parameters"""


@dataclass(frozen=True)
class Entry:
    """One calibration."""

    instrument: str
    date: str
    """ISO 8601"""
    parameters: Mapping[str, Value]
    """node parameter -> value"""
    residual: float
    """rms residual, in the unit of the reading"""
    uncertainty: Mapping[str, float] = field(default_factory=dict)
    """parameter -> standard error"""
    unit: str = ""
    notes: str = ""

    def __post_init__(self) -> None:
        if self.instrument not in INSTRUMENTS:
            raise ValueError(
                f"calibration: unknown instrument '{self.instrument}'"
                f"{nearest_hint(self.instrument, INSTRUMENTS)}"
            )
        try:
            datetime.date.fromisoformat(str(self.date))
        except ValueError:
            raise ValueError(
                f"{self.instrument}: date '{self.date}' is no date; write it as 2026-05-31"
            ) from None
        object.__setattr__(self, "date", str(self.date))
        known = INSTRUMENTS[self.instrument].parameters
        if not isinstance(self.parameters, Mapping):
            raise ValueError(f"{self.instrument}: 'parameters' must be names and values")
        for name, value in self.parameters.items():
            if name not in known:
                raise ValueError(f"{self.instrument}: unknown '{name}'{nearest_hint(name, known)}")
            if not _of_its_kind(name, value):
                raise ValueError(f"{self.instrument}: {name} is {value!r}; calibrate it again")

    def age(self, today: datetime.date) -> int:
        """Age of the calibration [days]."""
        return (today - datetime.date.fromisoformat(self.date)).days


def book_for(folder: Path) -> CalibrationBook:
    """Calibration book of a campaign folder, else of the working directory."""
    own = folder / FILE
    return CalibrationBook((own if own.exists() else Path(FILE)).resolve())


class CalibrationBook:
    """Calibrations by instrument; the newest is used."""

    def __init__(self, path: Path) -> None:
        """Read the book if it exists; ValueError names what is wrong with it."""
        self.path = path
        self.entries = _read(path) if path.is_file() else {}

    def add(self, entry: Entry) -> None:
        """Add an entry and write it to disk at once."""
        self.entries[entry.instrument] = entry
        plain = {}
        for name, e in self.entries.items():
            values = asdict(e)
            del values["instrument"]
            plain[name] = values
        text = dump_yaml({"format": FORMAT, "entries": plain})
        self.path.parent.mkdir(parents=True, exist_ok=True)
        write_atomic(self.path, text)

    def parameters(self) -> dict[str, dict[str, Value]]:
        """node -> parameters from the book; ValueError when a file among them is missing."""
        found: dict[str, dict[str, Value]] = {}
        for name, entry in self.entries.items():
            values = dict(entry.parameters)
            if FIT in values:
                values[FIT] = str(self.fit())
            for node in INSTRUMENTS[name].nodes:
                found.setdefault(node, {}).update(values)
        return found

    def fit(self) -> Path:
        """File of the parasitic fit; ValueError when there is none."""
        entry = self.entries.get("parasitic")
        if entry is None:
            raise ValueError(f"{self.path}: no parasitic fit; flatplank calibrate parasitic")
        path = self.path.parent / str(entry.parameters[FIT])
        if not path.exists():
            raise ValueError(f"{self.path}: no file {path}; put it back, or calibrate parasitic")
        return path

    def status(self, today: datetime.date) -> dict[str, str]:
        """instrument -> valid, expired or absent, with date; goes into every run record."""
        found = {}
        for name, instrument in INSTRUMENTS.items():
            entry = self.entries.get(name)
            if entry is None:
                found[name] = "absent"
            elif entry.age(today) > instrument.days:
                found[name] = f"expired: of {entry.date}, valid for {instrument.days} days"
            else:
                found[name] = f"valid: of {entry.date}"
        return found

    def record(self, today: datetime.date, in_force: Constants) -> dict[str, Any]:
        """The `calibration` of a run record: parameters of the running nodes, with the entry of
        the book."""
        stale = {
            (node, key)
            for node, values in self.parameters().items()
            for key, value in values.items()
            if node in in_force and not np.array_equal(in_force[node][key], value)
        }
        found = {}
        for name, text in self.status(today).items():
            _, keys, nodes = INSTRUMENTS[name]
            if stale.intersection((node, key) for node in nodes for key in keys):
                text = f"not in force: of {self.entries[name].date}; start the bench again"
            values = next((in_force[node] for node in nodes if node in in_force), {})
            found[name] = {"status": text, **{k: _plain(values[k]) for k in keys if k in values}}
        return found


def _of_its_kind(name: str, value: Any) -> bool:
    if name == FIT:
        return isinstance(value, str)
    if name in FRICTION:
        return isinstance(value, list) and bool(value) and all(map(is_number, value))
    return is_number(value)


def _plain(value: Any) -> Value:
    """A table as a list, as YAML has it."""
    return value if isinstance(value, (str, int, float)) else [float(v) for v in value]


def _read(path: Path) -> dict[str, Entry]:
    entries = load_format(path.read_bytes(), path, FORMAT).get("entries")
    if not isinstance(entries, dict):
        raise ValueError(f"{path}: no 'entries:' with instruments below it")
    return {name: _entry(name, values, path) for name, values in entries.items()}


def _entry(name: str, values: Any, path: Path) -> Entry:
    if not isinstance(values, dict):
        raise ValueError(f"{path}: {name}: expected date, parameters and residual below it")
    try:
        return Entry(**{**values, "instrument": name})
    except TypeError as error:
        what = str(error).split("__init__() ")[-1]
        raise ValueError(f"{path}: {name}: {what}") from None
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
