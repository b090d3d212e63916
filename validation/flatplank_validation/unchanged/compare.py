# SPDX-License-Identifier: Apache-2.0
"""Compares the facts of two versions."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

Facts = Mapping[str, Mapping[str, Any]]
"""part -> fact -> value"""
SAME = 1e-6
"""relative difference up to which two numbers are equal [-]"""


def differences(before: Facts, now: Facts) -> dict[str, list[str]]:
    """part -> lines on missing and changed facts; new facts are no difference."""
    parts = (part for part in before if part in now)
    return {part: list(_lines(before[part], now[part])) for part in parts}


def _lines(before: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[str]:
    for name, value in before.items():
        if name not in now:
            yield f"{name} is gone"
        elif isinstance(value, Mapping) and isinstance(now[name], Mapping):
            yield from (f"{name}: {line}" for line in _lines(value, now[name]))
            if part := [key for key in now[name] if key not in value]:
                yield f"{name} has more: {', '.join(part)}"
        elif not _same(value, now[name]):
            yield f"{name} was {value}, is {now[name]}"


def _same(before: Any, now: Any) -> bool:
    if isinstance(before, list) and isinstance(now, list):
        return len(before) == len(now) and all(map(_same, before, now))
    if isinstance(before, float) and isinstance(now, float):
        both_nan = math.isnan(before) and math.isnan(now)
        return both_nan or math.isclose(before, now, rel_tol=SAME)
    return bool(before == now)


def table(now: Facts, before: Facts | None) -> str:
    """One line per part: number of facts, and whether they equal those of the other version."""
    found = differences(before, now) if before is not None else {}
    rows = []
    for part, facts in now.items():
        verdict = ""
        if before is not None:
            lines = found.get(part)
            verdict = "not there before" if lines is None else f"{len(lines)} differ"
            verdict = "same" if lines == [] else verdict
        rows.append(f"{part:12} {len(facts):5}  {verdict}".rstrip())
        rows += [f"  {line}" for line in found.get(part, [])]
    return "\n".join(rows)
