# SPDX-License-Identifier: Apache-2.0
"""The table of `bench-trust`, and docs/reference/trust.md around it."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

from flatplank_hw.drive import DriveParameters
from flatplank_validation.trust.faults import FAULTS
from flatplank_validation.trust.registry import Result, rows
from flatplank_validation.trust.scenario import most_s

Found = Mapping[str, Result]
"""row -> result"""

HEAD = """\
# What the bench can be trusted with

Faults, damage and wrong numbers, tried by the thousand. Each row is a function in
`validation/flatplank_validation/trust/rows`; a new one needs the decorator `row` and nothing
else. `./flatplank bench-trust` tries a hundredth of it in minutes, `--long` the whole. Failed
cases are printed one by one.
"""
TAIL = """\
## The faults on a running EtherCAT bus

`FLATPLANK_SEED=N ./flatplank test --long tests/ethercat/test_ethercat_fault_pairs.py` draws 120
pairs of the faults of frames, cables, slaves, mailboxes and drive, and puts them one after the
other, 8 to 60 ms apart, on the emulated bus of a real master. At the plant's shaft the wheel must
rest within 100 ms of the second fault, in bench time. Nothing may be enabled by itself when the
bus recovers, and after a reset the wheel must turn again. Seeds 2 and 31: no pair of 240 failed.
A bridge amplifier without power, before or after each of the nine cut cables, at each of the 14
distances: none of 504 failed (all of 252, twice). In an older version a single pair of this kind
was enabled by itself; its cause is not known, and it did not come again.

## The faults on the twin

The wheel slips under load on the moving plank, rolls freely there, or turns in the air. The
faults begin within half a second of each other. From the first fault on the shaft of the simulated
machine must rest, or turn as its good source wants it to, in free rolling no faster than the road;
it may do otherwise for {most:.2f} s, in which the slowest rules notice a drive that obeys nothing,
and stop it. A drive that is deaf keeps its last set-point; its bus chip has a watchdog of its own,
as every EtherCAT drive has. What stops what:
[decisions/stop-authorities.md](../decisions/stop-authorities.md).

"""


def table(found: Found) -> list[str]:
    """Markdown table: how many of what, how many failed, where; then what else was measured."""
    known = rows()
    lines = [
        "| what is tried | failed means | how many | share of a night | failed | time | on |",
        "|---|---|---|---|---|---|---|",
    ]
    for name, result in found.items():
        row, tally = known[name], result.tally
        share = f"{100.0 * result.share:.3g} %, seed {ranges(result.seeds)}"
        lines.append(
            f"| {row.what} (`{name}`) | {row.bar} | {tally.many} | {share} "
            f"| {len(tally.failures)} | {result.seconds:.0f} s | {result.place} |"
        )
    notes = [f"- `{name}`: {note}" for name, r in found.items() for note in r.tally.notes]
    return [*lines, "", *notes] if notes else lines


def ranges(seeds: Sequence[int]) -> str:
    """Seeds in order; those that follow each other as a range."""
    runs: list[list[int]] = []
    for seed in sorted(seeds):
        if runs and seed == runs[-1][-1] + 1:
            runs[-1].append(seed)
        else:
            runs.append([seed])
    return ", ".join(f"{r[0]} to {r[-1]}" if len(r) > 2 else ", ".join(map(str, r)) for r in runs)


MUTANTS = """\
## Small faults in the code

`python tests/mutation/mutate.py --near --journal FILE` turns a sign, a comparison or a condition
round, or leaves a call out, one at a time, and asks the tests of the area. Wanted are nine of ten.
The samples are small: of 14 faults 9 noticed mean 35 to 87 %. A fault that changes no result
counts as not noticed, too.

| area | faults tried | noticed | share |
|---|---|---|---|
"""


def mutants(journals: Sequence[Path]) -> str:
    """Section on the faults of the journals of `mutate.py`; empty without one."""
    areas: dict[str, list[bool]] = {}
    for journal in journals:
        for line in journal.read_text(encoding="utf-8").splitlines():
            fault = json.loads(line)
            areas.setdefault(fault["area"], []).append(bool(fault["killed"]))
    rows = [
        f"| {name} | {len(found)} | {sum(found)} | {100.0 * sum(found) / len(found):.0f} % |"
        for name, found in sorted(areas.items())
    ]
    return "\n".join([MUTANTS.rstrip("\n"), *rows, ""]) if rows else ""


def absent(found: Found) -> list[str]:
    """Rows that were not measured for the page."""
    names = [f"`{name}`: {row.what}" for name, row in rows().items() if name not in found]
    return [f"Not measured for this page: {'; '.join(names)}.", ""] if names else []


def page(found: Found, journals: Sequence[Path] = ()) -> str:
    """The whole page."""
    names, most = ", ".join(FAULTS), most_s(DriveParameters())
    tail = f"{TAIL.format(most=most)}{names}."
    return "\n".join(
        [
            HEAD,
            "Measured by `./flatplank bench-trust --only ROW --share SHARE --seed SEED --json`,",
            "put together with `--from FILE... --write FILE`. A row of several seeds was measured",
            "in several runs; its share is the sum of theirs.",
            "",
            *table(found),
            "",
            *absent(found),
            mutants(journals),
            tail,
            "",
        ]
    )
