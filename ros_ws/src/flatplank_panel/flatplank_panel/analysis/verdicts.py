# SPDX-License-Identifier: Apache-2.0
"""What the journals of a folder say of its runs: good, rejected, made again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from flatplank_control.runner.campaign import SUFFIX, read_lines

Line = Mapping[str, Any]


def verdicts_of(folder: str | Path) -> dict[str, str]:
    """File of a run -> what the campaign thought of it; runs that no journal knows are absent."""
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
    """Of attempt `k` of a run."""
    reasons = _reasons(lines[k].get("facts") or {})
    if lines[k]["ok"]:
        return reasons or "good"
    later = f", made again as {lines[k + 1]['file']}" if k + 1 < len(lines) else ""
    return f"rejected{later}: {reasons}"


def _reasons(facts: Line) -> str:
    """The journal's words; those of older versions have only numbers."""
    numbers = (f"{name} {value:.3g}" for name, value in (facts.get("findings") or {}).items())
    return str(facts.get("verdict") or "") or ", ".join(numbers)
