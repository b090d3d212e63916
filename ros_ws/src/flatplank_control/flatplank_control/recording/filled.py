# SPDX-License-Identifier: Apache-2.0
"""A run record whose missing fields are filled in from the messages in the bag."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path

import yaml

from flatplank_data.bags.topics import OWN
from flatplank_data.errors import FlatplankError, RecordingError
from flatplank_data.limits import RECORDED
from flatplank_data.measured import UNKNOWN, reconciled
from flatplank_data.readers.bag import MEASURED, import_bag
from flatplank_data.run_record import RunRecord, record_from_dict, record_from_yaml

ESSENTIAL = frozenset({"measurement", "kappa", "fz"})
"""keys without which a record is filled in"""
BY_HAND = "by_hand"
"""name of a bag that was given none, with nothing to make one of"""


@dataclass(frozen=True)
class Told:
    """A record, and which of its keys somebody has said."""

    record: RunRecord
    said: Collection[str]

    @property
    def whole(self) -> bool:
        """Nothing has to be read out of the bag."""
        return set(self.said) >= ESSENTIAL

    def filled_in(self, record: RunRecord, bag: Path) -> RunRecord:
        """The record of a bag that is still open with what its messages show of the other keys.

        What was said stays; where the messages show something else the notes say so.
        """
        try:
            measured = import_bag(bag, OWN).facts[MEASURED]
            own = {key: value for key, value in measured.items() if key not in self.said}
            filled = record.with_changes(**own, filled_in=sorted(own))
        except (FlatplankError, RecordingError) as error:
            return _noted(record, f"not filled in: {error}")
        for problem in reconciled(filled, measured)[1]:
            filled = _noted(filled, problem.what)
        return filled


def told(text: str, name: str = "") -> Told:
    """The record of a start request: YAML, empty when there is none, and the name of the bag."""
    if not text.strip():
        record = record_from_dict({"tire": UNKNOWN, "name": name or BY_HAND})
        return Told(record, {"name"} if name else ())
    _refuse_settings(text)
    found = Told(record_from_yaml(text, "record"), set(data := yaml.safe_load(text)))
    name = name or data.get("name", "")
    if not name and not found.whole:
        name = f"{found.record.tire}_{BY_HAND}"
    return Told(found.record.with_changes(name=name), found.said) if name else found


def _refuse_settings(text: str) -> None:
    """RecordingError for what the machine cannot be set to; all else is the record's to judge."""
    try:
        data = yaml.safe_load(text)
    except yaml.YAMLError:
        return
    for key, value in data.items() if isinstance(data, Mapping) else ():
        known = key in RECORDED and isinstance(value, (int, float))
        if known and (reason := RECORDED[key].refusal(key, value)):
            raise RecordingError(f"record: {reason}")


def in_words(record: RunRecord) -> str:
    """What was recorded, on one line for people."""
    if not record.cycles_received:
        return (
            "nothing was recorded: the plank did not start to move "
            "(at_once: true records a bench at rest)"
        )
    words = [record.measurement.replace("_", " ")]
    if record.measurement == "slip":
        name = (record.waveform or {}).get("name", "step")
        words[0] += f" {100 * record.kappa:+g} %" if name == "step" else f" {name}"
        if math.isfinite(record.step_position):
            words.append(f"from {record.step_position:g} m")
    if math.isfinite(record.effective_rolling_radius):
        words.append(f"r_e {1e3 * record.effective_rolling_radius:.1f} mm")
    words += [f"Fz {record.fz:g} N"] if record.fz > 0.0 else []
    words.append(f"tire {record.tire}" + ("" if record.pressure > 0.0 else ", pressure not said"))
    cycles = record.cycles_received + record.cycles_lost
    return ", ".join([*words, f"{record.cycles_lost} of {cycles} cycles lost"])


def _noted(record: RunRecord, text: str) -> RunRecord:
    return record.with_changes(notes=f"{record.notes}; {text}" if record.notes else text)
