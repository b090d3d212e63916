# SPDX-License-Identifier: Apache-2.0
"""Answer and score of a challenge in words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from flatplank_data.wording import quantity

DIAGNOSIS = "diagnosis.json"
"""file of a diagnosis in a challenge's folder"""


def text_of(answer: Mapping[str, Any], points: Mapping[str, Any]) -> list[str]:
    """The answer and the score in words."""
    hidden = [f"{e['name']}, {_size(e)}" for e in answer["effects"]]
    hidden += [_outside(answer["outside"])] if answer.get("outside") else []
    lines = [f"hidden: {'; '.join(hidden) or 'nothing'}"]
    lines += [_effect(e) for e in points["effects"]]
    if points["outside_found"] is not None:
        lines.append(f"its place was {'' if points['outside_found'] else 'not '}found")
    if points["false"]:
        lines.append(f"named without cause: {', '.join(points['false'])}")
    return [*lines, "the diagnosis is right" if points["right"] else "the diagnosis is not right"]


def _effect(e: Mapping[str, Any]) -> str:
    """What became of one hidden effect."""
    if not e["named"]:
        kin = f"; {e['kin']} was named, which is like it but not it" if e["kin"] else ""
        return f"not found: {e['name']}{kin}"
    how = e["as"] if e["as"] == e["name"] else f"one of the group of {e['as']}"
    if not e["comparable"]:
        return f"found as {how}, whose size is another quantity"
    inside = "covers" if e["covered"] else "misses"
    off = "" if e["error"] is None else f" ({100 * e['error']:+.0f} %)"
    return f"found as {how}: {_size(e)}{off}, its interval {inside} the truth"


def _size(e: Mapping[str, Any]) -> str:
    """With its unit; of what grows from run to run, with their number."""
    over = f" over {e['runs']} runs" if e.get("runs") else ""
    return quantity(e["size"], e["unit"]) + over


def _outside(what: Mapping[str, Any]) -> str:
    low, high = what["range"]
    period = f", period {what['period']:.3g}" if what.get("period") else ""
    return f"outside the library: over {what['coordinate']} {low:.3g} to {high:.3g}{period}"
