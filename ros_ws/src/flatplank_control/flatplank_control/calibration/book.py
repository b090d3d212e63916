# SPDX-License-Identifier: Apache-2.0
"""The calibrations of a bench in one file: which, when, how good, and whether they still hold."""

from __future__ import annotations

import datetime
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import yaml

from flatplank_control.recording.metadata import replace_text
from flatplank_hw.params import nearest

FORMAT = "flatplank-calibration/1"
FILE = "calibration.yaml"
VALID_DAYS = {"hub": 730, "lvdt": 365, "plank_encoder": 365, "motor": 365, "parasitic": 30}
"""instrument -> days for which a calibration is believed"""


@dataclass(frozen=True)
class Entry:
    """One calibration."""

    instrument: str
    date: str
    """ISO 8601"""
    parameters: Mapping[str, float | str]
    """names and values for the parameter files of the nodes"""
    residual: float
    """rms, in the unit of the reading"""
    uncertainty: Mapping[str, float] = field(default_factory=dict)
    """standard error of each parameter"""
    unit: str = ""
    notes: str = ""

    def __post_init__(self) -> None:
        if self.instrument not in VALID_DAYS:
            raise ValueError(
                f"calibration: unknown instrument '{self.instrument}'"
                f"{nearest(self.instrument, VALID_DAYS)}"
            )
        datetime.date.fromisoformat(self.date)

    def age(self, today: datetime.date) -> int:
        """[days]"""
        return (today - datetime.date.fromisoformat(self.date)).days


def book_for(folder: Path) -> Book:
    """The book of a campaign folder, else that of the working directory."""
    own = folder / FILE
    return Book(own if own.exists() else Path(FILE))


class Book:
    """Entries by instrument; the newest counts."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.entries: dict[str, Entry] = {}
        if path.exists():
            data = yaml.safe_load(path.read_text(encoding="utf-8"))
            if not isinstance(data, dict) or data.get("format") != FORMAT:
                raise ValueError(f"{path}: not a calibration file; expected 'format: {FORMAT}'")
            for name, values in data["entries"].items():
                self.entries[name] = Entry(instrument=name, **values)

    def add(self, entry: Entry) -> None:
        """Put it down, on disk at once."""
        self.entries[entry.instrument] = entry
        plain = {}
        for name, e in self.entries.items():
            values = asdict(e)
            del values["instrument"]
            plain[name] = values
        text = yaml.safe_dump({"format": FORMAT, "entries": plain}, sort_keys=False)
        self.path.parent.mkdir(parents=True, exist_ok=True)
        replace_text(self.path, text)

    def status(self, today: datetime.date) -> dict[str, str]:
        """instrument -> valid, expired or absent, with date: for every run record."""
        found = {}
        for name, days in VALID_DAYS.items():
            entry = self.entries.get(name)
            if entry is None:
                found[name] = "absent"
            elif entry.age(today) > days:
                found[name] = f"expired: of {entry.date}, {days} days are believed"
            else:
                found[name] = f"valid: of {entry.date}"
        return found

    def record(self, today: datetime.date) -> dict[str, Any]:
        """The `calibration` of a run record."""
        status = self.status(today)
        return {
            name: {"status": text, **dict(self.entries[name].parameters)}
            if name in self.entries
            else {"status": text}
            for name, text in status.items()
        }
