# SPDX-License-Identifier: Apache-2.0
"""Scores one diagnosis against its answer, and counts many with Wilson intervals."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from flatplank_sim.sealed.score import NOTHING_VERDICTS, score


def points_of(entry: Mapping[str, Any]) -> dict[str, Any]:
    """Score of one journal entry, by the rules of `flatplank reveal`."""
    diagnosis, answer = entry["diagnosis"], entry["answer"]
    found = score(diagnosis, answer)
    hidden = answer["effects"]
    matched = list(zip(found["effects"], hidden, strict=True))
    sizes = [m for m, h in matched if m["named"] and h["sized"]]
    out = {
        "group": entry["case"]["group"],
        "truth": "+".join(entry["case"]["hidden"]) or "nothing",
        "first": found["first"],
        "verdict": diagnosis["verdict"],
        "false": len(found["false"]),
        "all": all(m["named"] for m in found["effects"]),
        "first_right": found["first_right"],
        "outside_found": found["outside_found"],
        "named": sum(m["named"] for m in found["effects"]),
        "unsized": sum(m["named"] and not h["sized"] for m, h in matched),
        "sizes": [_size(m) for m in sizes],
        "own_name": all(m.get("as") == m["name"] for m in found["effects"]),
        "held_out": None,
        "right": found["right"],
        "kin_right": found["kin_right"],
        "silent": diagnosis["verdict"] in NOTHING_VERDICTS and not found["false"],
    }
    floor = diagnosis["floor_rmse"]
    if out["all"] and hidden and floor:
        out["held_out"] = diagnosis["held_out_after"] / floor
    return out


def _size(match: Mapping[str, Any]) -> dict[str, Any]:
    own = match["as"] == match["name"]
    return {k: match[k] for k in ("covered", "error", "comparable")} | {"own": own}


@dataclass(frozen=True)
class Share:
    """A share of trials with its 95 % Wilson interval."""

    hits: int
    trials: int

    @property
    def value(self) -> float:
        """Hits over trials."""
        return self.hits / self.trials if self.trials else math.nan

    def interval(self, z: float = 1.96) -> tuple[float, float]:
        """Wilson interval."""
        n = self.trials
        if not n:
            return math.nan, math.nan
        middle = (self.value + z * z / (2 * n)) / (1 + z * z / n)
        half = z / (1 + z * z / n) * math.sqrt(
            self.value * (1 - self.value) / n + z * z / (4 * n * n)
        )  # fmt: skip
        return max(middle - half, 0.0), min(middle + half, 1.0)

    def __str__(self) -> str:
        if not self.trials:
            return "-"
        low, high = self.interval()
        return f"{self.hits}/{self.trials} = {self.value:.0%} ({low:.0%} .. {high:.0%})"


def share(flags: Iterable[bool]) -> Share:
    """Share of true flags."""
    listed = [bool(f) for f in flags]
    return Share(sum(listed), len(listed))


def confusion(points: Sequence[Mapping[str, Any]]) -> dict[str, dict[str, int]]:
    """Confusion matrix: truth -> name -> count."""
    table: dict[str, dict[str, int]] = {}
    for p in points:
        row = table.setdefault(p["truth"], {})
        row[p["first"]] = row.get(p["first"], 0) + 1
    return table
