# SPDX-License-Identifier: Apache-2.0
"""Nearest known names, for the end of an error message; of the standard library alone."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


def similar_names(key: str, known: Iterable[str], least: float = 0.4, most: int = 1) -> list[str]:
    """Known names similar to `key`, the nearest first; `least` 0 .. 1: smallest similarity."""
    return get_close_matches(str(key), sorted(known), n=most, cutoff=least)


def nearest_hint(key: str, known: Iterable[str]) -> str:
    """Hint at the nearest known name, to end an error message with."""
    names = sorted(known)
    match = similar_names(key, names)
    return f"; the nearest is '{match[0]}'" if match else f"; known are {', '.join(names)}"
