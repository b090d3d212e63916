# SPDX-License-Identifier: Apache-2.0
"""Blind test of the proposals: forces in no library.

Forces in no library, effects left out of it, and nothing hidden.
"""

from __future__ import annotations

import argparse
import fnmatch
import sys
import time
from pathlib import Path

from flatplank_data.arguments import Parser
from flatplank_data.files import write_atomic
from flatplank_validation.blind.detectable import cache
from flatplank_validation.blind.journal import publish, read
from flatplank_validation.proposed import journal
from flatplank_validation.proposed.cases import full
from flatplank_validation.proposed.page import TITLE, page

SEED = 70923
"""seed of the table in the docs"""


def parser() -> argparse.ArgumentParser:
    p = Parser(prog="flatplank bench-propose", description=__doc__)
    p.add_argument("--seed", type=int, default=SEED)
    p.add_argument("--limit", type=int, help="only so many of the list, which is mixed")
    p.add_argument("--only", default="*", metavar="PATTERN", help="of the names, as in 'null/*'")
    p.add_argument("--minutes", type=float, default=1e9, help="no campaign is begun after these")
    p.add_argument("--journal", type=Path, help="file that is gone on with; default: .cache/blind")
    p.add_argument("--no-run", action="store_true", help="only from what the journal has")
    p.add_argument(
        "--any-code", action="store_true", help="with --no-run: results of older code, too"
    )
    p.add_argument(
        "--rivals", type=int, metavar="N", help="N forces beside what else makes formulas"
    )
    p.add_argument(
        "--write", type=Path, metavar="FILE", help="the page; what stands above it stays"
    )
    return p


def main(argv: list[str]) -> int:
    """Exit code 0: all cases within the time are scored; 2: nothing to do."""
    o = parser().parse_args(argv)
    path = o.journal or cache() / f"propose{o.seed}.jsonl"
    cases = [c for c in full(o.seed) if fnmatch.fnmatch(c.key, o.only)][: o.limit]
    if not cases:
        print(f"bench-propose: --only '{o.only}' leaves no campaign", file=sys.stderr)
        return 2
    until = time.monotonic() + 60.0 * o.minutes
    if o.no_run:
        known = journal.of_this_code(read(path), o.seed, o.any_code)
        entries = [known[c.key] for c in cases if c.key in known]
    else:
        entries = journal.run(cases, o.seed, path, until, time.monotonic, _show)
    command = " ".join(["./flatplank bench-propose", *argv])
    header = {"command": command, "seed": o.seed, "whole": len(cases)}
    if o.rivals is not None:
        from flatplank_validation.proposed.beside import side_by_side

        file = path.with_name(f"{path.stem}_rivals.jsonl")
        header["rivals"] = side_by_side(o.seed, o.rivals, file, not o.no_run, _show)
    text = page(entries, header)
    if o.write:
        publish(o.write.with_suffix(".jsonl.gz"), header, entries)
        write_atomic(o.write, head_of(o.write) + text)
        print(f"{len(entries)} campaigns: {o.write}")
    else:
        print(text)
    return 0


def head_of(path: Path, title: str = TITLE) -> str:
    """Text above the test results in the file, which is kept."""
    old = path.read_text(encoding="utf-8") if path.is_file() else ""
    return old.split(title)[0]


def _show(done: int, count: int, key: str) -> None:
    print(f"propose {done}/{count} {key}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
