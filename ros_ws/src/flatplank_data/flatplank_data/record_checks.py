# SPDX-License-Identifier: Apache-2.0
"""Converts and checks the values of a run record in a file."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import Field
from typing import Any
from uuid import UUID

from flatplank_data.condition import is_nan
from flatplank_data.errors import FlatplankError, RecordingError
from flatplank_data.limits import IN_FILES, SHARE
from flatplank_data.names import nearest_hint
from flatplank_data.values import is_number

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
_TEXTS = ("tire", "name", "uuid", "measurement", "serial", "operator", "status", "notes")
_DIRECTIONS = {"forward": 1.0, "reverse": -1.0, "reversed": -1.0, "backward": -1.0}


def default_of(item: Field) -> Any:
    """Default value of a field."""
    return item.default_factory() if callable(item.default_factory) else item.default


def converted(item: Field, value: Any, where: str) -> Any:
    """The value in the type of the field. Raises FlatplankError where it must be a number."""
    kind = str(item.type)
    if value is None:
        return default_of(item)
    if item.name == "direction" and str(value) in _DIRECTIONS:
        return _DIRECTIONS[str(value)]
    try:
        if item.name == "pressure" and not float(value):
            return math.nan  # a pressure of 0 means not known
        if kind == "float":
            return float(value)
        if kind == "int":
            return int(value)
    except (TypeError, ValueError) as error:
        remedy = "write one number" if kind == "float" else "write one whole number"
        raise FlatplankError(f"'{item.name}: {value}' is not a number", where, remedy) from error
    return str(value) if kind == "str" else value


def check_keys(values: Mapping[str, Any], known: Mapping[str, Field], where: str) -> None:
    """Raise RecordingError for a key that is not in `known`."""
    for key in values:
        if key not in known:
            raise RecordingError(f"{where}: unknown key {key!r}{nearest_hint(key, known)}")


def check_values(values: Mapping[str, Any], known: Mapping[str, Field]) -> None:
    """Raise RecordingError for the first value that a record of this bench cannot have."""
    for key in _TEXTS:
        if not isinstance(values.get(key, ""), str):
            raise RecordingError(f"{key} is {values[key]!r}; it must be text")
    for key, limit in IN_FILES.items():
        value = values.get(key)
        default = known[key].default
        if key not in values or (value is None and is_nan(default)):
            continue
        if not is_number(value) or not limit.low <= float(value) <= limit.high:
            unit = "-" if limit.unit in ("", SHARE) else limit.unit  # as the file has it
            span = f"{limit.low:g} to {limit.high:g} [{unit}]"
            raise RecordingError(f"{key} is {value!r}; it must be {span}")
    if values.get("tire") == "":
        raise RecordingError("tire is empty; name the tire, for example TOY")
    if "status" in values and values["status"] not in STATUSES:
        known_words = ", ".join(STATUSES)
        raise RecordingError(f"status {values['status']!r} is unknown; use {known_words}")
    if "uuid" in values:
        _check_uuid(values["uuid"])


def _check_uuid(text: str) -> None:
    try:
        UUID(text)
    except ValueError:
        raise RecordingError(f"uuid {text!r} is none; leave it out to get one") from None
