# SPDX-License-Identifier: Apache-2.0
"""Sealed challenges: the answer beside a campaign, and how a diagnosis is scored against it.

A sealed file, `answer.sealed`, is JSON: `{"format": "flatplank-sealed/1", "answer": TEXT}`, TEXT
being base64 of zlib of this JSON:

    {"seed": 7, "tire": "bristles", "effects": [{"name": "road_play", "size": 0.0009,
     "unit": "m", "class": ["..."], "detectable": 0.0003}], "outside": {"coordinate":
     "plank position", "range": [2.0, 2.8], "period": null} or null, "notes": "..."}

`class` holds other names that count as right; no effects and no outside means that nothing is
hidden. The seal keeps eyes off, it does not keep secrets: nothing in the analysis reads the file
except `unseal`, which `flatplank reveal` calls.
"""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flatplank_analysis.errors import FlatplankError

FORMAT = "flatplank-sealed/1"
NAME = "answer.sealed"
LARGEST_CLASS = 4
LAW = "tire_law"
"""no fault of the machine: it says that the force law is of another form, and is never false"""
SILENT = ("none of these", "partly")
"""verdicts that fit what is in no library"""
QUIET = ("at floor", "tire law only")
"""verdicts that fit where nothing is hidden"""


def seal(answer: Mapping[str, Any], folder: str | Path) -> Path:
    """Write an answer so that it is not read by accident."""
    packed = base64.b64encode(zlib.compress(json.dumps(answer, sort_keys=True).encode()))
    path = Path(folder) / NAME
    path.write_text(json.dumps({"format": FORMAT, "answer": packed.decode()}) + "\n")
    return path


def unseal(folder: str | Path) -> dict[str, Any]:
    """Open the sealed answer of a campaign folder."""
    path = Path(folder) / NAME
    try:
        raw = json.loads(path.read_text(encoding="utf-8"))
        if raw.get("format") != FORMAT:
            raise FlatplankError(f"is not of format {FORMAT}", str(path), "make it again")
        return dict(json.loads(zlib.decompress(base64.b64decode(raw["answer"]))))
    except FileNotFoundError as error:
        raise FlatplankError(
            "nothing is sealed here", str(path), "`flatplank simulate --hidden SEED` seals"
        ) from error
    except (ValueError, KeyError, AttributeError, zlib.error) as error:
        raise FlatplankError("is damaged", str(path), "make the campaign again") from error


def score(diagnosis: Mapping[str, Any], answer: Mapping[str, Any]) -> dict[str, Any]:
    """Compare the JSON of a diagnosis with an answer.

    right: everything hidden is named (class of four at most) and nothing else is; what is in no
    library is said to be left, at its place; where nothing is hidden the verdict says so. Sizes
    and intervals are judged effect by effect.
    """
    hidden = list(answer.get("effects") or [])
    outside = answer.get("outside")
    named = [n for n in diagnosis.get("effects") or [] if n["name"] != LAW]
    matches, left = _match(hidden, named)
    false = [n["name"] for n in left]
    verdict = str(diagnosis.get("verdict"))
    right = all(m["named"] for m in matches) and not false
    if outside:
        right = right and verdict in SILENT and _covers(diagnosis, outside)
    elif not hidden:
        right = right and verdict in QUIET
    return {
        "right": bool(right),
        "first": named[0]["name"] if named else verdict,
        "verdict": verdict,
        "effects": matches,
        "false": false,
        "false_alarm": bool(not hidden and not outside and named),
        "first_right": bool(named and hidden and any(_fits(h, named[0]) for h in hidden)),
        "outside_found": bool(_covers(diagnosis, outside)) if outside else None,
    }


def _names(one: Mapping[str, Any]) -> set[str]:
    return {str(one["name"]), *map(str, one.get("class") or [])}


def _fits(hidden: Mapping[str, Any], named: Mapping[str, Any]) -> bool:
    mine = _names(named)
    return len(mine) <= LARGEST_CLASS and bool(mine & _names(hidden))


def _match(hidden: list, named: list) -> tuple[list[dict[str, Any]], list]:
    left = list(named)
    out = []
    for h in hidden:
        one = next((n for n in left if _fits(h, n)), None)
        entry: dict[str, Any] = {"name": h["name"], "named": one is not None}
        if one is not None:
            left.remove(one)
            truth, size = float(h["size"]), float(one["size"])
            low, high = (float(v) for v in one["interval"])
            entry |= {
                "as": one["name"],
                "truth": truth,
                "size": size,
                "error": (size - truth) / truth if truth else None,
                "covered": low <= truth <= high,
            }
        out.append(entry)
    return out, left


def _covers(diagnosis: Mapping[str, Any], outside: Mapping[str, Any]) -> bool:
    """True when the diagnosis points at the place (or period) of what is in no library."""
    rest = diagnosis.get("unexplained") or {}
    period, found = outside.get("period"), rest.get("period")
    if period:
        return bool(found) and abs(float(found) / float(period) - 1.0) < 0.05
    for place in rest.get("where") or []:
        if place["coordinate"] == outside.get("coordinate"):
            low, high = (float(v) for v in outside["range"])
            return float(place["range"][0]) < high and float(place["range"][1]) > low
    return False
