# SPDX-License-Identifier: Apache-2.0
"""Mappings from YAML to frozen dataclasses; an unknown key names the nearest known one."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from flatplank_data.params import nearest


class BusFileError(ValueError):
    """A bus file that cannot be used: one line saying what, where and what to do."""


def mapping(value: Any, where: str) -> Mapping[str, Any]:
    """The value itself when it is a mapping, else an error that says where."""
    if not isinstance(value, Mapping):
        raise BusFileError(f"{where}: expected a mapping, found {type(value).__name__}")
    return value


def sequence(value: Any, where: str) -> list[Any]:
    """The value itself when it is a list (or nothing: an empty one), else an error."""
    if value is None:
        return []
    if not isinstance(value, list):
        raise BusFileError(f"{where}: expected a list, found {type(value).__name__}")
    return value


def check_keys(
    value: Mapping[str, Any], known: Iterable[str], where: str, required: Iterable[str] = ()
) -> None:
    """Refuse keys that nobody reads and complain about those that are missing."""
    known = list(known)
    for key in value:
        if key not in known:
            raise BusFileError(f"{where}: unknown key '{key}'{nearest(key, known)}")
    for key in required:
        if key not in value:
            raise BusFileError(f"{where}: key '{key}' is missing")


def integer(value: Any, where: str, low: int = 0, high: int = 0xFFFFFFFF) -> int:
    """An integer (decimal or 0x...) in a range."""
    if isinstance(value, str):
        try:
            value = int(value, 0)
        except ValueError:
            raise BusFileError(f"{where}: '{value}' is not a whole number") from None
    if isinstance(value, bool) or not isinstance(value, int):
        raise BusFileError(f"{where}: {value!r} is not a whole number")
    if not low <= value <= high:
        raise BusFileError(f"{where}: {value} is outside {low}..{high}")
    return value


def number(value: Any, where: str) -> float:
    """A finite number."""
    if isinstance(value, bool) or not isinstance(value, int | float) or value - value != 0:
        raise BusFileError(f"{where}: {value!r} is not a number")
    return float(value)
