# SPDX-License-Identifier: Apache-2.0
"""Writes the results of loops from a journal, as text and into docs/guide/investigate.md."""

from __future__ import annotations

import statistics
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from flatplank_sim.sealed.menu import MENU
from flatplank_validation.blind.points import share
from flatplank_validation.evaluation.version import of_which_search
from flatplank_validation.investigate.cases import NULL, POLICIES, alarm, right

Entry = Mapping[str, Any]
TITLE = "## How well it does"
WORDS = {
    "loop": "the loop", "fixed": "the plan of 27 runs", "text": "the run that `diagnose` names",
    "random": "runs at random",
}  # fmt: skip


def policy_of(e: Entry) -> str:
    """How the runs of an entry were chosen."""
    return e["key"].split("/")[1]


def lines(entries: Sequence[Entry]) -> Iterator[str]:
    """Shares with Wilson intervals, medians of the minutes, one line per policy."""
    for row in rows(entries):
        yield (
            f"{row['policy']}: right {row['right']}, median {row['minutes']} min where right, "
            f"{row['all']} of all, {row['runs']} runs; nothing hidden: named {row['named']}, with "
            f"evidence {row['alarms']}, median {row['null_minutes']} min"
        )
    yield from pairs(entries)


def rows(entries: Sequence[Entry]) -> Iterator[dict[str, Any]]:
    """Results of each policy."""
    for policy in POLICIES:
        own = [e for e in entries if policy_of(e) == policy]
        some = [e for e in own if e["hidden"] != NULL]
        none = [e for e in own if e["hidden"] == NULL]
        good = [e for e in some if right(e)]
        if own:
            yield {
                "policy": policy, "right": share(map(right, some)), "minutes": _middle(good),
                "all": _middle(some), "runs": _middle(some, "runs"),
                "named": share(bool(e["named"]) for e in none),
                "alarms": share(map(alarm, none)), "null_minutes": _middle(none),
            }  # fmt: skip


def _middle(entries: Sequence[Entry], key: str = "minutes") -> str:
    return f"{statistics.median(e[key] for e in entries):.0f}" if entries else "-"


def pairs(entries: Sequence[Entry]) -> Iterator[str]:
    """Comparison of the loop with the plan of 27 runs on the same tires, and the computing time of
    the loop."""
    loops = {_tire(e): e for e in entries if policy_of(e) == "loop"}
    plans = {_tire(e): e for e in entries if policy_of(e) == "fixed"}
    both = [(loops[k], plans[k]) for k in loops if k in plans and loops[k]["hidden"] != NULL]
    if both:
        more = share(a["minutes"] > b["minutes"] for a, b in both)
        ratio = statistics.median(a["minutes"] / b["minutes"] for a, b in both)
        yield (
            f"Same tires, something hidden ({len(both)}): the loop took {100 * ratio:.0f} % of "
            f"the plan's minutes in the median, more than the plan in {more}."
        )
    told = [e for e in loops.values() if e["decoys"][0]]
    if told:
        looked, taken = (sum(e["decoys"][i] for e in told) for i in (0, 1))
        yield f"Decoys of {len(told)} loops: {taken} of {looked} accepted."
    seconds = [s for e in loops.values() for s in e["planning"]]
    if seconds:
        yield (
            f"A choice took {statistics.median(seconds):.1f} s of processor in the median, "
            f"{max(seconds):.1f} s at most, of {len(seconds)}."
        )


def _tire(e: Entry) -> tuple[str, str]:
    return e["hidden"], e["key"].rsplit("/", 1)[1]


def page(entries: Sequence[Entry], header: Mapping[str, Any]) -> str:
    """The end of the page in Markdown."""
    versions = Counter(f"{e['commit']} (code {e['code']})" for e in entries)
    count = Counter(policy_of(e) for e in entries)
    made = ", ".join(f"{count[p]} of {WORDS[p]}" for p in POLICIES if count[p])
    nulls = [e for e in entries if e["hidden"] == NULL and policy_of(e) == "loop"]
    table = [
        "| runs chosen by | right | minutes where right | minutes of all | runs | "
        "nothing hidden: named | ... with e >= 20 | minutes |",
        "|---|---|---|---|---|---|---|---|",
        *(
            f"| {WORDS[r['policy']]} | {r['right']} | {r['minutes']} | {r['all']} | {r['runs']} | "
            f"{r['named']} | {r['alarms']} | {r['null_minutes']} |"
            for r in rows(entries)
        ),
    ]
    parts = [
        TITLE,
        f"Written by `{header['command']}` from {len(entries)} investigations of seed "
        f"{header['seed']}: {made}; {len(nulls)} loops with nothing hidden. "
        f"{', '.join(versions)}. Nothing from here on is typed by hand.",
        of_which_search(e["commit"] for e in entries),
        "The fast generator (`validation/flatplank_validation/investigate/fast.py`) draws a tire "
        "and hides an effect of the menu of sealed challenges, of a size that is usual there; "
        "every way of choosing meets the same tires, its runs have noise of their own. Right: "
        "what is hidden is in the class that is named, and nothing is named beside it. Minutes "
        "are medians; intervals are Wilson's, 95 %.",
        "\n".join(table),
        *pairs(entries),
        "\n".join(["| hidden | " + " | ".join(WORDS[p] for p in POLICIES if count[p]) + " |",
                   "|---|" + "---|" * sum(1 for p in POLICIES if count[p]),
                   *_by_effect(entries, [p for p in POLICIES if count[p]])]),
    ]  # fmt: skip
    return "\n\n".join(parts) + "\n"


def _by_effect(entries: Sequence[Entry], policies: Sequence[str]) -> Iterator[str]:
    """Number of right results per effect, and median of the minutes."""
    for hidden in MENU:
        cells = []
        for policy in policies:
            own = [e for e in entries if e["hidden"] == hidden and policy_of(e) == policy]
            good = sum(map(right, own))
            cells.append(f"{good}/{len(own)}, {_middle(own)} min" if own else "")
        if any(cells):
            yield f"| {hidden} | " + " | ".join(cells) + " |"
