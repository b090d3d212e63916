# SPDX-License-Identifier: Apache-2.0
"""Faults, damage and wrong numbers, tried by the thousand."""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
import time
from collections.abc import Sequence
from functools import partial, reduce
from pathlib import Path

from flatplank_data.arguments import Parser, add_json
from flatplank_data.files import write_atomic
from flatplank_data.params import nearest_hint
from flatplank_validation.trust.page import page, table
from flatplank_validation.trust.registry import Options, Result, Tally, rows

FORMAT = "flatplank-bench-trust/2"
SHARE = 0.01
"""share of a night's cases without --long"""


def parser() -> argparse.ArgumentParser:
    """Command line."""
    p = Parser(prog="flatplank bench-trust", description=__doc__)
    p.add_argument("--long", action="store_true", help="as many as in a night; else a hundredth")
    p.add_argument("--share", type=float, help="another share of the cases of a night, 0 to 1")
    p.add_argument("--seed", type=int, default=1, help="of the drawn cases")
    p.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="processes")
    p.add_argument("--only", default="", metavar="ROW", help="one row of the table")
    p.add_argument("--write", type=Path, metavar="FILE", help="write the page of the docs")
    p.add_argument(
        "--from", dest="earlier", nargs="+", type=Path, default=[], metavar="FILE",
        help="put together what earlier runs have written with --json, and measure nothing",
    )  # fmt: skip
    p.add_argument(
        "--mutants", nargs="+", type=Path, default=[], metavar="FILE",
        help="journals of tests/mutation/mutate.py, for --write",
    )  # fmt: skip
    add_json(p)
    return p


def say(name: str, done: int, count: int) -> None:
    """Progress of a row."""
    end = "\n" if done == count or not sys.stderr.isatty() else "\r"
    print(f"{name}: {done} of {count}", end=end, file=sys.stderr, flush=True)


def earlier(files: Sequence[Path]) -> dict[str, Result]:
    """Results of earlier runs, in the order of the table; those of other seeds are added."""
    found: dict[str, dict[tuple[int, ...], Result]] = {}
    for file in files:
        try:
            raw = json.loads(file.read_text(encoding="utf-8"))
            if raw["format"] != FORMAT:
                raise ValueError(f"format is {raw['format']!r}, must be {FORMAT!r}")
            for name, r in raw["rows"].items():
                tally = Tally(int(r["many"]), list(r["failures"]), notes=list(r["notes"]))
                seeds = tuple(map(int, r["seeds"]))
                found.setdefault(name, {})[seeds] = Result(
                    tally, float(r["seconds"]), float(r["share"]), seeds, str(r["on"])
                )
        except (OSError, KeyError, TypeError, ValueError) as error:
            raise SystemExit(f"bench-trust: {file}: {error}; give an output of --json") from None
    return {name: reduce(Result.join, found[name].values()) for name in rows() if name in found}


def place() -> str:
    """Commit, where the code has one, and kind of machine."""
    words = ["git", "-C", str(Path(__file__).parent), "describe", "--always", "--dirty", "--tags"]
    try:
        told = subprocess.run(words, capture_output=True, text=True, check=False).stdout.strip()
    except OSError:
        told = ""
    kind = f"{platform.system()} {platform.machine()}, {os.cpu_count()} processors"
    return ", ".join(filter(None, (told, kind)))


def measure(o: argparse.Namespace, share: float) -> dict[str, Result]:
    """Results of the rows that are asked for."""
    known = rows()
    if o.only and o.only not in known:
        raise SystemExit(f"bench-trust: no row '{o.only}'{nearest_hint(o.only, known)}")
    found = {}
    for name in [o.only] if o.only else known:
        began = time.monotonic()
        options = Options(share, o.seed, o.jobs, partial(say, name))
        tally = known[name].run(options)
        lasted = time.monotonic() - began
        found[name] = Result(tally, lasted, share, (o.seed,), place())
    return found


def main(argv: list[str]) -> int:
    """Print the table; exit code 0: no case has failed, 1: some have."""
    o = parser().parse_args(argv)
    share = o.share if o.share is not None else 1.0 if o.long else SHARE
    if not 0.0 < share <= 1.0:
        raise SystemExit(f"bench-trust: --share is {share:g}, must be above 0 and at most 1")
    found = earlier(o.earlier) if o.earlier else measure(o, share)
    if o.json:
        plain = {
            name: {"many": r.tally.many, "failed": len(r.tally.failures),
                   "failures": r.tally.failures, "notes": r.tally.notes, "seconds": r.seconds,
                   "share": r.share, "seeds": r.seeds, "on": r.place}
            for name, r in found.items()
        }  # fmt: skip
        print(json.dumps({"format": FORMAT, "rows": plain}, indent=1))
    elif o.write:
        write_atomic(o.write, page(found, o.mutants))
        print(f"written: {o.write}")
    else:
        print("\n".join(table(found)))
    for name, result in found.items():
        for text in result.tally.failures:
            print(f"{name}: {text}", file=sys.stderr)
    return 1 if any(result.tally.failures for result in found.values()) else 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
