# SPDX-License-Identifier: Apache-2.0
"""Scores a diagnosis against an answer, strictly by what the diagnosis states.

A hidden effect is found when an entry of the diagnosis has its name. It is also found when it is
in the class of an entry, the class has at most four names, and the verdict says that it is a
group. Relatives in the answer are reported separately (`kin`) and do not count as right.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from flatplank_analysis.words import COORDINATES
from flatplank_data.wording import quantity, span

LARGEST_CLASS = 4
GROUP = "found group"
FOUND_VERDICTS = ("found", GROUP)
LAW = "tire_law"
"""effect for another form of the force law; it is no fault of the machine and never counts as
false"""
UNEXPLAINED_VERDICTS = ("none of these", "partly")
"""right verdicts for an effect outside the library"""
NOTHING_VERDICTS = ("at floor", "tire law only")
"""right verdicts when nothing is hidden"""

Entry = Mapping[str, Any]
Fits = Callable[[Entry, Entry], bool]


def score(diagnosis: Entry, answer: Entry) -> dict[str, Any]:
    """Compare the JSON of a diagnosis with an answer.

    right: all hidden effects are found and no other is named; a force outside the library is
    reported as unexplained, at its location; where nothing is hidden the verdict says so.
    kin_right: the same when relatives count, too. `present` of an answer has true effects of the
    tire that are not asked for: naming them is neither right nor false, nor is a group that has
    one of them in its class. Sizes are judged effect by
    effect; an interval in another unit than the hidden size does not cover it.
    """
    hidden = list(answer.get("effects") or [])
    outside = answer.get("outside")
    present = set(map(str, answer.get("present") or []))
    free = {LAW, *present}
    everything = diagnosis.get("effects") or []
    named = [n for n in everything if n["name"] not in free]
    verdict = str(diagnosis.get("verdict"))

    def claimed(n: Entry) -> set[str]:
        return _class(n) if verdict == GROUP else _class(n) & {str(n["name"])}

    def strict(h: Entry, n: Entry) -> bool:
        return h["name"] in claimed(n)

    def false_beside(found: Sequence[Entry | None]) -> list[Entry]:
        return [n for n in _rest(named, found) if not claimed(n) & present]

    pairs, kin_pairs = _assign(hidden, named, strict), _assign(hidden, named, _kin)
    false = false_beside(pairs)
    place = _covers(diagnosis, outside) if outside else None

    def right(found: Sequence[Entry | None]) -> bool:
        whole = None not in found and not false_beside(found)
        if outside:
            return whole and verdict in UNEXPLAINED_VERDICTS and bool(place)
        true_of_it = any(n["name"] != LAW for n in everything)
        nothing = verdict in NOTHING_VERDICTS or (true_of_it and verdict in FOUND_VERDICTS)
        return whole and (bool(hidden) or nothing)

    runs = int(diagnosis.get("runs") or 0)
    return {
        "right": right(pairs),
        "kin_right": right(kin_pairs),
        "first": named[0]["name"] if named else verdict,
        "verdict": verdict,
        "effects": [_match(*three, runs) for three in zip(hidden, pairs, kin_pairs, strict=True)],
        "false": [n["name"] for n in false],
        "false_alarm": bool(not hidden and not outside and false),
        "first_right": bool(named) and any(strict(h, named[0]) for h in hidden),
        "outside_found": place,
    }


def _class(named: Entry) -> set[str]:
    """Names in the class of an entry; none when there are too many for an answer."""
    names = {str(named["name"]), *map(str, named.get("class") or [])}
    return names if len(names) <= LARGEST_CLASS else set()


def _kin(hidden: Entry, named: Entry) -> bool:
    return bool(_class(named) & {str(hidden["name"]), *map(str, hidden.get("class") or [])})


def _assign(hidden: Sequence[Entry], named: Sequence[Entry], fits: Fits) -> list[Entry | None]:
    """For each hidden effect the entry that names it; an exact name has priority."""
    out: list[Entry | None] = [None] * len(hidden)
    free = list(named)
    for same in (True, False):
        for i, h in enumerate(hidden):
            choice = [n for n in free if fits(h, n) and (h["name"] == n["name"]) >= same]
            if out[i] is None and choice:
                out[i] = choice[0]
                free.remove(choice[0])
    return out


def _rest(named: Sequence[Entry], found: Sequence[Entry | None]) -> list[Entry]:
    return [n for n in named if not any(n is f for f in found)]


def _match(hidden: Entry, named: Entry | None, kin: Entry | None, runs: int) -> dict[str, Any]:
    out: dict[str, Any] = {"name": hidden["name"], "named": named is not None}
    if named is None:
        return out | {"kin": kin["name"] if kin else None}
    truth, size = float(hidden["size"]), float(named["size"])
    over = int(hidden.get("runs") or 0)
    if over and runs:  # a size that grows from run to run: scale it to the runs of the diagnosis
        truth *= (runs - 1) / (over - 1)
    low, high = (float(v) for v in named["interval"])
    units = {hidden.get("unit"), named.get("unit")} - {None}
    comparable = len(units) < 2
    return out | {
        "as": named["name"],
        "alone": not named.get("class"),
        "truth": truth,
        "size": size,
        "unit": named.get("unit") or hidden.get("unit") or "1",
        "comparable": comparable,
        "error": (size - truth) / truth if truth and comparable else None,
        "covered": comparable and low <= truth <= high,
        **({"runs": runs} if over and runs else {}),
    }


def _covers(diagnosis: Entry, outside: Entry) -> bool:
    """True when the diagnosis gives the location (or period) of a force outside the library."""
    rest = diagnosis.get("unexplained") or {}
    period, found = outside.get("period"), rest.get("period")
    if period:
        return bool(found and abs(float(found) / float(period) - 1.0) < 0.05)
    low, high = (float(v) for v in outside["range"])
    return any(
        place["coordinate"] == outside.get("coordinate")
        and float(place["range"][0]) < high
        and float(place["range"][1]) > low
        for place in rest.get("where") or []
    )


DIAGNOSIS = "diagnosis.json"
"""file name of a diagnosis in the folder of a challenge"""


def text_of(answer: Mapping[str, Any], points: Mapping[str, Any]) -> list[str]:
    """The answer and the score as text."""
    hidden = [f"{e['name']}, {_size(e)}" for e in answer["effects"]]
    hidden += [_outside(answer["outside"])] if answer.get("outside") else []
    lines = [f"hidden: {'; '.join(hidden) or 'nothing'}"]
    lines += [_effect(e) for e in points["effects"]]
    if points["outside_found"] is not None:
        lines.append(f"its location was {'' if points['outside_found'] else 'not '}found")
    if points["false"]:
        lines.append(f"named without cause: {', '.join(points['false'])}")
    right = "right" if points["right"] else "not right"
    if not points["effects"]:
        return [*lines, f"verdict: {right}"]
    return [*lines, f"group: {right}", f"name: {_name(points)}"]


def _name(points: Mapping[str, Any]) -> str:
    """Whether each cause has one name, the right one."""
    if not points["right"]:
        return "not right"
    alone = all(e["as"] == e["name"] and e["alone"] for e in points["effects"])
    return "right" if alone else "open, the group has other members"


def _effect(e: Mapping[str, Any]) -> str:
    """Text about one hidden effect."""
    if not e["named"]:
        kin = f"; {e['kin']} was named, a similar effect" if e["kin"] else ""
        return f"not found: {e['name']}{kin}"
    how = e["as"] if e["as"] == e["name"] else f"one of the group of {e['as']}"
    if not e["comparable"]:
        return f"found as {how}, whose size is another quantity"
    inside = "covers" if e["covered"] else "misses"
    off = "" if e["error"] is None else f" ({100 * e['error']:+.0f} %)"
    return f"found as {how}: {_size(e)}{off}, its interval {inside} the truth"


def _size(e: Mapping[str, Any]) -> str:
    """Size with its unit, and the number of runs for a size that grows from run to run."""
    over = f" over {e['runs']} runs" if e.get("runs") else ""
    return quantity(e["size"], e["unit"]) + over


def _outside(what: Mapping[str, Any]) -> str:
    unit = COORDINATES[what["coordinate"]].unit
    period = f", period {quantity(what['period'], unit)}" if what.get("period") else ""
    low, high = what["range"]
    place = span(low, high, unit)
    return f"outside the library: over the {what['coordinate']} {place}{period}"
