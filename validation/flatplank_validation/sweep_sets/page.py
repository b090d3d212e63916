# SPDX-License-Identifier: Apache-2.0
"""Tables of the benchmark of the search on sweeps, and its page."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from flatplank_analysis.discovery.sources import AT_FLOOR, FOUND, LAW
from flatplank_validation.blind.points import Share, share
from flatplank_validation.sweep_sets.forms import FormOf
from flatplank_validation.sweep_sets.sets import CAUSES, NOISE, SERIES

Entry = Mapping[str, Any]
SILENT = (AT_FLOOR, LAW)
HIDDEN = ", ".join(name for name, _ in CAUSES.values())
HEADER: tuple[str, ...] = (
    "series", "noise [N]", "hidden", "named", "size (90 %)", "verdict", "floor [N]", "before [N]",
    "after [N]",
)  # fmt: skip


def summary(entries: Sequence[Entry]) -> dict[str, Share]:
    """Shares with their intervals (Wilson, 95 %)."""
    nulls = [e for e in entries if not e["hidden"]]
    others = [e for e in entries if e["hidden"]]
    return {
        "nothing hidden, nothing named (wanted 19 of 20)": share(
            not set(e["named"]) - {"law_load"} for e in nulls
        ),
        "nothing hidden, at floor or tire law only (wanted 19 of 20)": share(
            e["verdict"] in SILENT for e in nulls
        ),
        "hidden, the right name first (wanted 85 %)": share(
            e["named"][:1] == [e["hidden"]] for e in others
        ),
        "hidden, the right name first and found": share(
            e["named"][:1] == [e["hidden"]] and e["verdict"] == FOUND for e in others
        ),
    }


def rows_of(entries: Iterable[Entry]) -> list[tuple[str, ...]]:
    """A line per series, after the header."""
    return [HEADER] + [
        (
            str(e["series"]), f"{e['noise']:.1f}", e["hidden"] or "-",
            ", ".join(e["named"]) or "-", e["size"] or "-", e["verdict"], f"{e['floor']:.1f}",
            f"{e['before']:.1f}", f"{e['after']:.1f}",
        )
        for e in entries
    ]  # fmt: skip


def form_rows(found: Iterable[FormOf]) -> list[tuple[str, ...]]:
    """A line per tire of another form, after the header."""
    header: tuple[str, ...] = (
        "tire",
        "base [N]",
        "free B, C, D, E [N]",
        "ratio",
        "verdict",
        "named",
    )
    return [header] + [
        (
            f.tire, f"{f.error:.1f}", f"{f.free:.1f}", f"{f.error / f.free:.2f}", f.verdict,
            ", ".join(f.named) or "-",
        )
        for f in found
    ]  # fmt: skip


def page(entries: Sequence[Entry], command: str) -> str:
    """The page in the docs."""
    head, *rows = rows_of(entries)
    commits = ", ".join(sorted({e["commit"] for e in entries}))
    low, high = NOISE
    wanted = [f"| {name} | {value} |" for name, value in summary(entries).items()]
    seconds = sorted(e["seconds"] for e in entries)
    lines = [
        "# The search on sweeps: generated series",
        "",
        f"Written by `{command} --write FILE` from {len(entries)} of {SERIES} series; {commits}.",
        "",
        "A series is a discrete brush on a belt: three loads, two pressures, each condition "
        f"twice, 7,200 samples, noise of {low:g} to {high:g} N. Half of the series hide nothing, "
        f"four each hide one of {HIDDEN}. The brush shares no code "
        "with the models; the base is a tire file fitted to the same brush with nothing hidden. "
        "Intervals in brackets are Wilson's, 95 %. The series are of one brush on one plan: other "
        "tires are in `bench-sweeps --forms`.",
        "",
        "| what | share |",
        "|---|---|",
        *wanted,
        "",
        f"A diagnosis takes {seconds[len(seconds) // 2]:.0f} s of processor time (median; at most "
        f"{seconds[-1]:.0f} s), reading included.",
        "",
        f"| {' | '.join(head)} |",
        f"|{'---|' * len(head)}",
        *(f"| {' | '.join(row)} |" for row in rows),
    ]
    return "\n".join([*lines, ""])
