# SPDX-License-Identifier: Apache-2.0
"""Writes the page docs/guide/propose.md, below its title, from a journal."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from statistics import median
from typing import Any

from flatplank_analysis.discovery.steps import LARGEST_CLASS
from flatplank_validation.blind.points import share
from flatplank_validation.evaluation.version import of_which_search
from flatplank_validation.proposed.left_out import PLAIN

Entry = Mapping[str, Any]
TITLE = "## How often it is right"
FLOORS, LEVELS, CLOSE = 1.1, 1.5, 0.15
NEAR = 0.3
"""largest error of a claimed force over the size of the true one, for a right claim [-]"""


def made(e: Entry) -> bool:
    """True when an effect was proposed."""
    return e["proposal"]["verdict"] == "proposed"


def right(e: Entry, part: str) -> bool:
    """True when one part of the proposal is right."""
    if not made(e):
        return False
    words = {"families": "family", "coordinates": "coordinate", "modulators": "modulator",
             "shapes": "shape"}  # fmt: skip
    return e["proposal"][words[part]] in e["answer"][part]


def whole(e: Entry) -> bool:
    """True when family, coordinate and modulator are right."""
    return all(right(e, p) for p in ("families", "coordinates", "modulators"))


def in_class(e: Entry) -> bool:
    """True when the proposal is right, or one that it calls indistinguishable."""
    if not made(e):
        return False
    said = [e["proposal"], *e["proposal"].get("confused_with", [])][:LARGEST_CLASS]
    return any(whole({**e, "proposal": {**e["proposal"], **one}}) for one in said)


def held(e: Entry) -> bool:
    """True when the 90 % interval of the size contains the hidden size."""
    low, high = sorted(abs(v) for v in e["proposal"]["refit"]["interval"])
    return bool(low <= e["answer"]["size"] <= high)


def at_floor(e: Entry, key: str, most: float) -> bool:
    """True when a held-out error of a proposal is within `most` noise floors."""
    refit = (e["proposal"].get("refit") or {}) if made(e) else {}
    return bool(refit) and refit[key] is not None and refit[key] <= most * refit["floor"]


def sized(e: Entry) -> bool:
    """True when the size is within 15 % of the hidden one."""
    refit, size = e["proposal"].get("refit") or {}, e["answer"]["size"]
    return bool(refit) and abs(abs(refit["size"]) - size) <= CLOSE * size


def rows_of(entries: Sequence[Entry]) -> list[tuple[str, str, Any]]:
    """Rows of the table: text, goal, share."""
    asked = [e for e in entries if e["proposal"] is not None]
    hidden = [e for e in asked if e["case"]["group"] != "null"]
    nulls = [e for e in asked if e["case"]["group"] == "null"]
    said = [e for e in hidden if made(e)]
    out = []

    def row(text: str, wanted: str, of: Sequence[Entry], test: Callable[[Entry], bool]) -> None:
        out.append((text, wanted, share(test(e) for e in of)))

    for name, group in (("forces in no library", "force"), ("effects left out", "left_out")):
        own = [e for e in hidden if e["case"]["group"] == group]
        row(f"{name}: something is proposed", "", own, made)
        row(f"{name}: family, coordinate and modulator right", ">= 80 %", own, whole)
    row("all: family, coordinate and modulator right", ">= 80 %", hidden, whole)
    row("the same and error in left-out conditions <= 1.1 floors", ">= 80 %", hidden,
        lambda e: whole(e) and at_floor(e, "held_out", FLOORS))  # fmt: skip
    row("all: right, or one of the four at most that it says cannot be told apart", "", hidden,
        in_class)  # fmt: skip
    row("form right, of all", ">= 70 %", hidden, lambda e: right(e, "shapes"))
    row("of those proposed: family", "", said, lambda e: right(e, "families"))
    row("of those proposed: coordinate", "", said, lambda e: right(e, "coordinates"))
    row("of those proposed: modulator", "", said, lambda e: right(e, "modulators"))
    row("of those proposed: left-out conditions <= 1.1 floors", "", said,
        lambda e: at_floor(e, "held_out", FLOORS))  # fmt: skip
    row("of those proposed: left-out level <= 1.5 floors", "all", said,
        lambda e: at_floor(e, "held_out_level", LEVELS))  # fmt: skip
    measured = [e for e in said if e["answer"]["size"] and whole(e) and right(e, "shapes")]
    row("sentence and form right, sizes comparable: within 15 %", "all", measured, sized)
    row("the same: its 90 % interval holds the hidden size", "90 %", measured, held)
    row("nothing hidden: something is proposed", "0", nulls, made)
    return out


def page(entries: Sequence[Entry], header: Mapping[str, Any]) -> str:
    """The whole page in Markdown."""
    versions = Counter(f"{e['commit']} (code {e['code']})" for e in entries)
    asked = [e for e in entries if e["proposal"] is not None]
    lines = [
        TITLE,
        f"Written by `{header['command']}` from {len(entries)} of the {header['whole']} campaigns "
        f"of seed {header['seed']}; {', '.join(versions)}. Nothing from here on is typed by hand; "
        "the journal that it is written from is [beside it](propose.jsonl.gz).",
        of_which_search(e["commit"] for e in entries),
        "The list is mixed, so that its beginning is a fair sample; read the intervals (Wilson, "
        "95 %). Designs have 15 runs of five slips (27 runs of nine slips for "
        f"{', '.join(f'`{n}`' for n in PLAIN)}, 45 runs where several loads are asked for). Sizes "
        "are three times what the generator could just see of that form, and three times the "
        "size of no consequence where that is larger; forces have at least half of what repeats "
        "differ by.",
        "| what | wanted | right |\n|---|---|---|\n"
        + "\n".join(f"| {text} | {wanted} | {s} |" for text, wanted, s in rows_of(entries)),
        "### By what was hidden",
        "| hidden | proposed | family, coordinate, modulator right | form, too |\n"
        "|---|---|---|---|\n" + "\n".join(_by_hidden(asked)),
        "### What was proposed",
        "Family, coordinate, modulator and form as proposed; a verdict in brackets where nothing "
        "was.",
        "| hidden | world | proposed | right | campaigns |\n|---|---|---|---|---|\n"
        + "\n".join(_alike(asked)),
        f"Seconds per campaign, median: {_median(asked):.0f} (on a busy machine, one process).",
    ]
    if header.get("rivals"):
        lines += beside(header["rivals"])
    return "\n\n".join(lines) + "\n"


def beside(entries: Sequence[Entry]) -> list[str]:
    """Results of proposals and rivals, as paragraphs."""
    head = (
        "| | claims a force | coordinate right | form right | error inside, median | outside, "
        f"median | both <= {NEAR:g} | seconds |\n|---|---|---|---|---|---|---|---|\n"
    )
    names = list(entries[0]["said"])
    return [
        "### Beside what else makes formulas",
        f"{len(entries)} campaigns of the list with a force of no library; all get the same rest "
        "and the same coordinates. Error: of the claimed force, over the size of the hidden one, "
        "a constant taken out; inside the campaign (slips to 5 %) and in new runs outside it "
        "(8 %). Nothing claimed is an error of 1. A free spline names the coordinate of its "
        "largest part, sparse regression that of its largest term, with its form; of a formula "
        "that was bred all coordinates must be right, and it names no form. Seconds are of "
        "processor time after the diagnosis.",
        head + "\n".join(_rival(name, [e["said"][name] for e in entries]) for name in names),
    ]


def _rival(name: str, rows: Sequence[Entry]) -> str:
    n = len(rows)

    def count(key: str) -> str:
        return f"{sum(bool(r.get(key)) for r in rows)}/{n}"

    def middle(key: str, nothing: float) -> float:
        return median(r.get(key, nothing) for r in rows)

    both = sum(max(r.get("inside", 1.0), r.get("outside", 1.0)) <= NEAR for r in rows)
    return (
        f"| {name} | {count('said')} | {count('coordinate')} | {count('form')} | "
        f"{middle('inside', 1.0):.2f} | {middle('outside', 1.0):.2f} | {both}/{n} | "
        f"{middle('seconds', 0.0):.0f} |"
    )


def _by_hidden(entries: Sequence[Entry]) -> Iterator[str]:
    """One row for each force or effect."""
    hidden = [e for e in entries if e["case"]["group"] != "null"]
    for name in sorted({e["case"]["name"] for e in hidden}):
        own = [e for e in hidden if e["case"]["name"] == name]
        formed = sum(whole(e) and right(e, "shapes") for e in own)
        said, good = sum(map(made, own)), sum(map(whole, own))
        yield f"| {name} | {said}/{len(own)} | {good}/{len(own)} | {formed}/{len(own)} |"


def _alike(entries: Sequence[Entry]) -> list[str]:
    """One row for all campaigns with the same answer."""
    rows = Counter(_row(e) for e in sorted(entries, key=lambda e: e["key"]))
    return [f"{row} {count} |" for row, count in rows.items()]


def _row(e: Entry) -> str:
    p, c = e["proposal"], e["case"]
    said = (
        ", ".join(w for w in (p["family"], p["coordinate"], p["modulator"], p["shape"]) if w)
        if made(e) else f"({p['diagnosis']})"
    )  # fmt: skip
    if c["group"] == "null":
        verdict = "no" if made(e) else "yes"
    else:
        verdict = "yes" if whole(e) else "no"
        verdict += ", form" if whole(e) and right(e, "shapes") else ""
    return f"| {c['name']} | {c['world']} | {said} | {verdict} |"


def _median(entries: Sequence[Entry]) -> float:
    times = sorted(e["proposal"]["seconds"] for e in entries)
    return times[len(times) // 2] if times else 0.0
