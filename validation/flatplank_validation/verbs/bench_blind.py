# SPDX-License-Identifier: Apache-2.0
"""Blind test of the discovery: hidden effects, strict scores.

Campaigns with known answers, scores, confusion matrix.
"""

from __future__ import annotations

import argparse
import fnmatch
import json
import sys
import time
from collections.abc import Callable
from pathlib import Path

from flatplank_data.arguments import Parser, add_json
from flatplank_validation.blind import journal
from flatplank_validation.blind.detectable import cache
from flatplank_validation.blind.lists import five_slips, full
from flatplank_validation.blind.page import page, summary
from flatplank_validation.blind.plain_size import with_plain_sizes
from flatplank_validation.evaluation.paired import of_the_same, paired

SEED = 20262
"""seed of the table in the docs; held out while the search was developed"""


def parser() -> argparse.ArgumentParser:
    p = Parser(prog="flatplank bench-blind", description=__doc__)
    p.add_argument("--small", action="store_true", help="five campaigns of five slips")
    p.add_argument(
        "--five-slips", action="store_true", help="the list, each campaign with few runs"
    )
    p.add_argument("--seed", type=int, default=SEED)
    p.add_argument(
        "--of", type=Path, metavar="JOURNAL",
        help="the campaigns that a published journal diagnosed, with its seed, in place of a list",
    )  # fmt: skip
    p.add_argument("--jobs", type=int, default=1, help="processes")
    p.add_argument("--limit", type=int, help="only so many of the list, which is mixed")
    p.add_argument("--only", default="*", metavar="PATTERN", help="of the names, as in 'pair/*'")
    p.add_argument("--journal", type=Path, help="file that is gone on with; default: .cache/blind")
    p.add_argument(
        "--beside", type=Path, metavar="JOURNAL",
        help="paired comparison with a journal of the same campaigns by other code: alone, or "
        "with --write on the page",
    )  # fmt: skip
    p.add_argument(
        "--write", type=Path, metavar="FILE", help="the page and, beside it, its journal"
    )
    p.add_argument(
        "--rivals", type=int, metavar="N", help="N of them side by side with today's ways"
    )
    p.add_argument("--no-run", action="store_true", help="only from what the journal has")
    p.add_argument(
        "--any-code",
        action="store_true",
        help="with --no-run: results of older code, too; with --of also of an older kit, where it "
        "hides the same",
    )
    add_json(p)
    return p


def show(began: float) -> Callable[[int, int, str], None]:
    """Make a progress callback: one line with the time left that is overwritten."""
    clear = "\r\033[K" if sys.stderr.isatty() else ""
    end = "" if sys.stderr.isatty() else "\n"
    first: list[int] = []

    def say(done: int, count: int, key: str) -> None:
        first.append(done)
        each = (time.monotonic() - began) / (done - first[0] + 1)
        left = f"{each * (count - done) / 60.0:.0f} min left"
        text = f"{clear}blind {done}/{count} {left} {key}"
        print(text, end="\n" if done == count else end, file=sys.stderr, flush=True)

    return say


def main(argv: list[str]) -> int:
    """Exit code 0: all campaigns of the list are scored; 2: nothing to do."""
    o = parser().parse_args(argv)
    of = journal.diagnosed(o.of) if o.of else []
    if of:
        o.seed = of[0]["seed"]
    path = o.journal or cache() / f"seed{o.seed}.jsonl"
    if of:
        listed = [journal.case_of(e) for e in of]
    else:
        listed = five_slips(o.seed) if o.five_slips else full(o.seed, o.small)
    cases = [c for c in listed if fnmatch.fnmatch(c.key, o.only)][: o.limit]
    if not cases:
        print(
            f"bench-blind: --only '{o.only}' with --limit {o.limit} leaves no campaign; "
            "names are like single/plant/road_play/x2/usual/s0.01/plain/0",
            file=sys.stderr,
        )
        return 2
    if o.no_run:
        found = journal.read(path)
        known = journal.of_this_code(found, o.seed, o.any_code)
        if of and o.any_code:
            known |= {k: dict(e) for k, e in of_the_same(found, of).items()}
        entries = [known[c.key] for c in cases if c.key in known]
    else:
        entries = journal.run(cases, o.seed, path, o.jobs, show(time.monotonic()))
    beside = paired(entries, journal.diagnosed(o.beside)) if o.beside else ""
    if o.beside and not o.write:
        print(beside)
        return 0
    entries = [with_plain_sizes(e) for e in entries]
    rivals = _rivals(o, path) if o.rivals is not None else []
    if o.json:
        print(json.dumps(summary(entries), indent=1))
        return 0
    command = " ".join(["./flatplank bench-blind", *argv])
    header = {
        "command": command, "seed": o.seed, "whole": len(cases), "rivals": rivals,
        "beside": beside,
    }  # fmt: skip
    text = page(entries, header)
    if o.write:
        from flatplank_data.files import write_atomic

        journal.publish(o.write.with_suffix(".jsonl.gz"), header, entries)
        write_atomic(o.write, text)
        print(f"{len(entries)} campaigns: {o.write}")
    else:
        print(text)
    return 0


def _rivals(o: argparse.Namespace, path: Path) -> list[dict]:
    from flatplank_validation.blind.rivals import side_by_side

    return side_by_side(
        o.seed,
        path.with_name(f"rivals{o.seed}.jsonl"),
        o.no_run,
        o.rivals,
        o.any_code,
        show(time.monotonic()),
    )


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
