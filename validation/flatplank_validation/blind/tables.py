# SPDX-License-Identifier: Apache-2.0
"""Tables of the page docs/reference/discovery-blind.md."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from flatplank_sim.sealed.score import NOTHING_VERDICTS, UNEXPLAINED_VERDICTS
from flatplank_validation.blind.markdown import table
from flatplank_validation.blind.plain_size import by_plain_sizes
from flatplank_validation.blind.points import Share, confusion, points_of, share

Points = Sequence[Mapping[str, Any]]
ONE = ("single", "combined")
"""groups with one hidden effect"""
CLEAR = 1.5
"""an effect must be named only above this multiple of its size of no consequence [-]"""
BINS = (0.9, 1.5, 3.0, 6.0, 20.0, math.inf)
"""bins of size over detectable size in the power curves [-]"""
POWER = 0.8


def scored(entries: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Scores of the diagnosed campaigns, with world, size ratio and whether the effect matters."""
    out = []
    for e in entries:
        if e["diagnosis"] is None:
            continue
        one = e["answer"]["effects"][:1] if e["case"]["group"] in ONE else []
        outside = e["answer"]["outside"] if e["case"]["group"] == "outside" else None
        p = points_of(e) | {"world": e["case"]["world"], "factor": e["case"]["factor"]}
        p |= {"rung": e["case"]["rung"], "clear": True, "ratio": math.nan, "plain_ratio": math.nan}
        p |= {"noise": f"{e['case']['noise']}, {e['case']['scatter']:.0%}", "said": _said(e)}
        p["own_ratio"] = _own_ratio(one, e["diagnosis"])
        plain = points_of(by_plain_sizes(e))["sizes"]
        p["sizes"] = [m | {"plain": b["covered"]} for m, b in zip(p["sizes"], plain, strict=True)]
        p["error"] = e["diagnosis"]["rmse_before"] / max(e["diagnosis"]["floor_rmse"], 1e-9)
        for h in one:
            p["ratio"] = h["size"] / h["detectable"]
            p["clear"] = h["size"] >= CLEAR * h["consequence"] * (1.0 - 1e-9)
            p |= {"hidden": h, "plain_ratio": h.get("plain", h["size"]) / h["consequence"]}
        if outside:  # older journals lack the size of no consequence
            p["ratio"] = outside.get("size", math.nan) / outside.get("detectable", math.nan)
            slight = outside.get("consequence", 0.0)
            p["clear"] = outside.get("size", math.inf) >= CLEAR * slight * (1.0 - 1e-9)
        out.append(p)
    return out


def _own_ratio(hidden: Sequence[Mapping[str, Any]], diagnosis: Mapping[str, Any]) -> float:
    """Hidden size over the smallest size that the search states for itself [-]; 0 where it states
    none, NaN for a pair, for an effect that it named, and where the units differ."""
    named, own = [e["name"] for e in diagnosis["effects"]], diagnosis.get("detectable") or {}
    for h in hidden:
        stated = own.get(h["name"])
        if stated is None and h["name"] not in named:
            return 0.0
        if stated and stated["unit"] == h["unit"]:
            return h["size"] / stated["size"]
    return math.nan


def _said(entry: Mapping[str, Any]) -> str:
    """The named effects, or the verdict in brackets."""
    names = [
        f"{e['name']} ({', '.join(e['class'])})" if e["class"] else e["name"]
        for e in entry["diagnosis"]["effects"]
    ]
    return ", ".join(names) or f"({entry['diagnosis']['verdict']})"


def _outside(low: float, high: float = math.inf) -> Callable[[Mapping], bool]:
    return lambda p: p["group"] == "outside" and p["clear"] and low <= p["ratio"] * 1.000001 < high


def _single(low: float, high: float = math.inf, clear: bool = True) -> Callable[[Mapping], bool]:
    return lambda p: (
        p["group"] == "single" and p["clear"] is clear and low <= p["ratio"] * 1.000001 < high
    )


def _group(name: str) -> Callable[[Mapping], bool]:
    return lambda p: p["group"] == name


ROWS: dict[str, tuple[str, Callable[[Mapping], bool]]] = {
    "none": ("nothing hidden: said so (goal 98 %)", _group("none")),
    "x1": ("one effect of consequence, 1 to 2 x detectable", _single(1.0, 2.0)),
    "x2": ("one effect of consequence, 2 x detectable and above (goal 90 %)", _single(2.0)),
    "x2near": ("... of these: 2 to 5 x", _single(2.0, 5.0)),
    "pair": ("two effects: both named, nothing false (goal 80 %)", _group("pair")),
    "combined": (
        "combined slip or loads from half to one and a half, one effect of consequence, "
        "2 x detectable and above (goal 95 %)",
        lambda p: p["group"] == "combined" and p["clear"] and p["ratio"] > 1.999,
    ),
    "outside1": (
        "outside the library, of consequence, 1 to 2 x detectable: said so, with place",
        _outside(1.0, 2.0),
    ),
    "outside2": ("outside the library, of consequence, 2 x detectable and above", _outside(2.0)),
}


def rows_of(points: Points) -> dict[str, list[Mapping[str, Any]]]:
    """Scores of each row."""
    return {key: [p for p in points if belongs(p)] for key, (_, belongs) in ROWS.items()}


def scores(points: Points) -> str:
    """Table of strict scores by world, with lenient ones beside."""
    worlds = sorted({p["world"] for p in points})
    rows = []
    for key, own in rows_of(points).items():
        cells = [str(share(p["right"] for p in own))]
        cells += [str(share(p["right"] for p in own if p["world"] == w)) for w in worlds]
        rows.append([ROWS[key][0], *cells, str(share(p["kin_right"] for p in own))])
    return table(["what", "strict", *worlds, "lenient"], rows)


def beside(points: Points) -> str:
    """Table of further results beside the scores."""
    strong = [p for p in points if ROWS["x2"][1](p)]
    single = [p for p in points if p["group"] in ONE]
    slight = [p for p in single if not p["clear"]]
    right = [p for p in strong if p["right"]]
    every = [p for p in points if p["group"] == "outside"]
    outside = [p for p in every if p["clear"]]
    faint = [p for p in every if not p["clear"]]
    nothing = [p for p in points if p["group"] == "none"]
    rows = {
        "2 x and above: the right name first or in the group, whatever follows": share(
            p["first_right"] for p in strong
        ),
        "2 x and above, right: by its own name": share(p["own_name"] for p in right),
        "2 x and above, right: verdict `partly`": share(p["verdict"] == "partly" for p in right),
        "one effect: something false named beside or instead": share(p["false"] for p in single),
        "one effect, too small to be of consequence: named rightly or not at all": share(
            p["right"] or p["silent"] for p in slight
        ),
        "one effect, not named: below the smallest size that the search states for itself": share(
            p["own_ratio"] < 1.0 for p in single if not p["named"]
        ),
        "outside the library, of consequence: `none of these` or `partly`, place aside": share(
            p["verdict"] in UNEXPLAINED_VERDICTS for p in outside
        ),
        "outside the library, too small to be of consequence: said so, or nothing named": share(
            p["right"] or not p["false"] for p in faint
        ),
        "nothing hidden: verdict `at floor` or `tire law only`": share(
            p["verdict"] in NOTHING_VERDICTS for p in nothing
        ),
    }
    return table(["what", "campaigns"], [[text, str(value)] for text, value in rows.items()])


def sizes(points: Points) -> str:
    """Table of interval coverage over all campaigns, size errors and held-out error."""
    worlds = sorted({p["world"] for p in points})

    def row(text: str, pick: Callable[[Mapping], bool], by: str = "covered") -> list[str]:
        own = [(p["world"], m[by]) for p in points for m in p["sizes"] if pick(m)]
        cells = [str(share(c for w, c in own if w == world)) for world in worlds]
        return [text, str(share(c for _, c in own)), *cells]

    rows = [
        row("90 % intervals that cover the truth, all (goal 85 .. 95 %)", lambda m: True),
        row("... named by its own name", lambda m: m["own"]),
        row("... as another of its group, same unit", lambda m: not m["own"] and m["comparable"]),
        row("... as another of its group, other unit: counted as not covering",
            lambda m: not m["comparable"]),
        row("90 % intervals that cover the size in the plain law, all", lambda m: True, "plain"),
    ]  # fmt: skip
    lines = [table(["what", "all", *worlds], rows), "", table(["what", "value"], _errors(points))]
    return "\n".join(lines)


def _errors(points: Points) -> list[list[str]]:
    found = [m["error"] for p in points for m in p["sizes"] if m["error"] is not None]
    errors = np.abs(found)
    held = np.array([p["held_out"] for p in points if p["held_out"] is not None])
    without = sorted({p["truth"] for p in points if p["unsized"]})
    named, unsized = sum(p["named"] for p in points), sum(p["unsized"] for p in points)
    rows = [["hidden effects that were named rightly", str(named)]]
    text = f"{unsized} ({', '.join(without)})" if unsized else "0"
    rows.append(["... whose hidden number is not the effect's own: no size is asked", text])
    if len(errors):
        rows.append(["median error of the size", f"{np.median(errors):.1%}"])
        rows.append(["sizes within 15 %", str(share(errors < 0.15))])
    if len(held):
        rows.append(["held-out error over floor, median", f"{np.median(held):.2f}"])
        rows.append(["held-out error at most 1.1 floors", str(share(held <= 1.1))])
    return rows


def power(points: Points) -> str:
    """Table of strictly right diagnoses over size / detectable size, per effect and in total."""
    single = [p for p in points if p["group"] in ONE]
    names = [f"{_ratio(a)} .. {_ratio(b)}" for a, b in zip(BINS[:-1], BINS[1:], strict=True)]
    rows = [["**all**", "", "", *_curve(single)], ["**all of consequence**", "", "",
            *_curve([p for p in single if p["clear"]])]]  # fmt: skip
    for truth in sorted({p["truth"] for p in single}):
        own = [p for p in single if p["truth"] == truth]
        hidden = [p["hidden"] for p in own]
        least = [h["detectable"] for h in hidden]
        unit, slight = hidden[0]["unit"], hidden[0]["consequence"]
        span = f"{min(least):.2g} .. {max(least):.2g} {unit}"
        times = f"{slight / max(least):.2g} .. {slight / min(least):.2g}"
        rows.append([truth, span, times, *_curve(own)])
    head = ["hidden", "detectable", "no consequence / detectable", *names, "80 % from"]
    return table(head, rows)


def _times(value: float) -> str:
    return "" if math.isnan(value) else f"{value:.1f} x"


def _ratio(value: float) -> str:
    return "inf" if math.isinf(value) else f"{value:g} x" if value >= 1.0 else "1 x"


def _curve(points: Points) -> list[str]:
    shares = [
        share(p["right"] for p in points if low <= p["ratio"] < high)
        for low, high in zip(BINS[:-1], BINS[1:], strict=True)
    ]
    cells = [f"{s.hits}/{s.trials}" if s.trials else "-" for s in shares]
    start = reached(shares)
    return [*cells, "-" if start is None else _ratio(BINS[start])]


def reached(shares: Sequence[Share]) -> int | None:
    """First bin from which on every bin with campaigns has the required power, or None."""
    start = None
    for i, s in reversed(list(enumerate(shares))):
        if s.trials and s.value < POWER:
            break
        start = i if s.trials else start
    return start


def matrix(points: Points) -> str:
    """Table of the effect named first, by truth."""
    verdicts = {*NOTHING_VERDICTS, *UNEXPLAINED_VERDICTS, "not decidable"}
    rows = []
    for truth, row in sorted(confusion(points).items()):
        ordered = sorted(row.items(), key=lambda item: -item[1])
        cells = [f"({n}) {c}" if n in verdicts else f"{n} {c}" for n, c in ordered]
        rows.append([truth, str(sum(row.values())), ", ".join(cells)])
    return table(["hidden", "campaigns", "named first"], rows)


ASKED = ("none", "x2", "pair", "combined", "outside2")
"""rows with a goal, and the row of forces of consequence outside the library"""


def how(point: Mapping[str, Any]) -> str:
    """Kind of error of a campaign that was not right."""
    if point["truth"] == "nothing" or (point["all"] and point["false"]):
        return "something false named beside"
    if point["false"]:
        return "another name instead"
    if point["named"]:
        return "one of two not named"
    return "nothing named" if point["error"] > 1.0 else "nothing named, error within the floor"


def missed(points: Points) -> str:
    """Table of all campaigns in rows with a goal that were not right: hidden effect, its size, the
    diagnosis."""
    rows = [
        [
            p["truth"], p["world"], p["noise"],
            _times(p["ratio"]), _times(p["own_ratio"]) if p["own_ratio"] else "none",
            _times(p["plain_ratio"]), f"{p['error']:.2f}", p["said"], how(p),
        ]
        for key, own in rows_of(points).items()
        if key in ASKED
        for p in own
        if not p["right"]
    ]  # fmt: skip
    head = ["hidden", "world", "noise, scatter", "size / detectable"]
    head += ["size / detectable by the search", "plain size / no consequence"]
    head += ["error / floor", "said", "how"]
    return table(head, rows)


def ways(points: Points) -> str:
    """Table of the kinds of error, by row."""
    found = {
        key: Counter(how(p) for p in own if not p["right"])
        for key, own in rows_of(points).items()
        if key in ASKED
    }
    names = sorted({way for row in found.values() for way in row})
    rows = [
        [ROWS[key][0], str(sum(row.values())), *(str(row[way] or "-") for way in names)]
        for key, row in found.items()
    ]
    return table(["what", "missed", *names], rows)
