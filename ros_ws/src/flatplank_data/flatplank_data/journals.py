# SPDX-License-Identifier: Apache-2.0
"""Reads journals of campaigns: their lines, and what they say of each run."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

SUFFIX = ".journal.jsonl"
Line = Mapping[str, Any]


def read_lines(path: Path) -> list[dict[str, Any]]:
    """Lines of a journal; a last line that was torn by a crash is ignored.

    ValueError for a damaged line in its midst: what follows it would be lost without a word.
    """
    if not path.exists():
        return []
    lines = []
    for i, text in enumerate(path.read_bytes()[: end_of_lines(path)].splitlines(), start=1):
        try:
            lines.append(dict(json.loads(text)))
        except (ValueError, TypeError):
            raise ValueError(
                f"{path}: line {i} is damaged; restore the journal from a copy, or remove the line"
            ) from None
    return lines


def end_of_lines(path: Path) -> int:
    """Size of a journal without a torn last line."""
    return path.read_bytes().rfind(b"\n") + 1


def verdicts_of(folder: str | Path) -> dict[str, str]:
    """file of a run -> verdict of the campaign; runs in no journal are absent."""
    found: dict[str, str] = {}
    for path in sorted(Path(folder).glob(f"*{SUFFIX}")):
        attempts: dict[str, list[Line]] = {}
        for line in read_lines(path):
            if line.get("event") == "end":
                attempts.setdefault(line["run"], []).append(line)
        for lines in attempts.values():
            found |= {line["file"]: _text(lines, k) for k, line in enumerate(lines)}
    return found


def _text(lines: Sequence[Line], k: int) -> str:
    """Verdict on attempt `k` of a run."""
    reasons = _reasons(lines[k].get("facts") or {})
    if lines[k]["ok"]:
        return reasons or "good"
    later = f", made again as {lines[k + 1]['file']}" if k + 1 < len(lines) else ""
    return f"rejected{later}: {reasons}"


def _reasons(facts: Line) -> str:
    """Text of the verdict in the journal; journals of older versions have only numbers."""
    numbers = (f"{name} {value:.3g}" for name, value in (facts.get("findings") or {}).items())
    return str(facts.get("verdict") or "") or ", ".join(numbers)
