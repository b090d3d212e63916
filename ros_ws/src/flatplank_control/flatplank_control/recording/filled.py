# SPDX-License-Identifier: Apache-2.0
"""Fills missing fields of a run record from the messages in the bag."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path

import yaml

from flatplank_data.bags.topics import OWN
from flatplank_data.errors import FlatplankError, RecordingError
from flatplank_data.limits import RECORDED
from flatplank_data.measured import UNKNOWN, with_values_in_use
from flatplank_data.readers.bag import MEASURED, import_bag
from flatplank_data.run_record import RunRecord, record_from_dict, record_from_yaml
from flatplank_data.yaml_text import parse_yaml

ESSENTIAL = frozenset({"measurement", "kappa", "fz"})
"""keys that a record must state; otherwise it is filled in"""
HOW_IT_ENDED = ("status", "stop_reason")
"""keys that the samples decide: the wheel was stopped on the way"""
BY_HAND = "by_hand"
"""name of a bag when neither request nor record gives one"""


@dataclass(frozen=True)
class RequestedRecord:
    """Record of a start request; `given_keys`: the keys that the request has set."""

    record: RunRecord
    given_keys: Collection[str]

    @property
    def has_essential_keys(self) -> bool:
        """True when the record needs no more from the bag than how the run ended."""
        return set(self.given_keys) >= ESSENTIAL

    def filled_in(self, record: RunRecord, bag: Path) -> RunRecord:
        """The record, completed from the messages of a bag that is still open.

        Keys of the request stay; where the messages differ, the notes say so.
        """
        try:
            measured = dict(import_bag(bag, OWN).facts[MEASURED])
            end = {key: measured.pop(key) for key in HOW_IT_ENDED if key in measured}
            own = {key: value for key, value in measured.items() if key not in self.given_keys}
            own = {} if self.has_essential_keys else own
            filled = record.with_changes(**own, **end, filled_in=sorted(own))
        except (FlatplankError, RecordingError) as error:
            return _noted(record, f"not filled in: {error}")
        for problem in with_values_in_use(filled, measured)[1]:
            filled = _noted(filled, problem.what)
        return filled


def requested_record(text: str, name: str = "") -> RequestedRecord:
    """Record of a start request; `text`: YAML, may be empty; `name`: name of the bag."""
    if not text.strip():
        record = record_from_dict({"tire": UNKNOWN, "name": name or BY_HAND})
        return RequestedRecord(record, {"name"} if name else ())
    _refuse_settings(text)
    found = RequestedRecord(record_from_yaml(text, "record"), set(data := parse_yaml(text)))
    name = name or data.get("name", "")
    if not name and not found.has_essential_keys:
        name = f"{found.record.tire}_{BY_HAND}"
    return (
        RequestedRecord(found.record.with_changes(name=name), found.given_keys) if name else found
    )


def _refuse_settings(text: str) -> None:
    """Raise RecordingError for settings beyond the machine; the record checks all other keys."""
    try:
        data = parse_yaml(text)
    except yaml.YAMLError:
        return
    for key, value in data.items() if isinstance(data, Mapping) else ():
        known = key in RECORDED and isinstance(value, (int, float))
        if known and (reason := RECORDED[key].refusal(key, value)):
            raise RecordingError(f"record: {reason}")


def in_words(record: RunRecord) -> str:
    """Summary of the recording, on one line for people."""
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
    words.append(f"tire {record.tire}" + ("" if record.pressure > 0.0 else ", pressure not given"))
    cycles = record.cycles_received + record.cycles_lost
    late = f", {record.cycles_late} late" if record.cycles_late else ""
    return ", ".join([*words, f"{record.cycles_lost} of {cycles} cycles lost{late}"])


def _noted(record: RunRecord, text: str) -> RunRecord:
    return record.with_changes(notes=f"{record.notes}; {text}" if record.notes else text)
