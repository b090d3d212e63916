# SPDX-License-Identifier: Apache-2.0
"""Plank time to the right answer, beside fixed plans.

The loop against the plan of 27 runs and against chance.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from flatplank_data.arguments import Parser, add_json
from flatplank_data.files import write_atomic
from flatplank_sim.sealed.menu import MENU
from flatplank_validation.blind.detectable import cache
from flatplank_validation.blind.journal import publish
from flatplank_validation.investigate.cases import (
    LIBRARIES,
    NULL,
    POLICIES,
    Case,
    of_this_code,
    run,
)
from flatplank_validation.investigate.nulls import lines_of_evidence
from flatplank_validation.investigate.page import TITLE, lines, page
from flatplank_validation.verbs.bench_propose import head_of

SEED = 20263
MINUTES = 172.0
"""duration of the plan of 27 runs [min]"""


def parser() -> argparse.ArgumentParser:
    p = Parser(prog="flatplank bench-investigate", description=__doc__)
    p.add_argument("--count", type=int, default=1, help="tires per effect and policy")
    p.add_argument("--nulls", type=int, default=1, help="tires with nothing hidden, per policy")
    p.add_argument("--policy", action="append", choices=sorted(POLICIES), help="default: all")
    p.add_argument("--library", choices=LIBRARIES, default="menu", help="effects looked for")
    p.add_argument("--minutes", type=float, default=MINUTES, help="budget of a loop")
    p.add_argument("--evidence", type=int, metavar="N", help="only e-values, of N nulls")
    p.add_argument("--seed", type=int, default=SEED)
    p.add_argument("--jobs", type=int, default=1, help="processes")
    p.add_argument("--journal", type=Path, help="default: .cache/blind/investigate.jsonl")
    p.add_argument("--no-run", action="store_true", help="only from what the journal has")
    p.add_argument(
        "--any-code", action="store_true", help="with --no-run: results of older code, too"
    )
    add_json(p)
    p.add_argument(
        "--write",
        type=Path,
        metavar="FILE",
        help="the page, its journal beside it; what stands above stays",
    )
    return p


def cases_of(o: argparse.Namespace) -> list[Case]:
    """List of cases in mixed order, so that it may be ended anywhere."""
    out = []
    for number in range(max(o.count, o.nulls)):
        for hidden in MENU:
            most = o.nulls if hidden == NULL else o.count
            for policy in o.policy or POLICIES:
                if number < most:
                    out.append(Case(hidden, policy, number, o.library))
    return out


def say(text: str) -> None:
    """Print the progress."""
    print(text, file=sys.stderr, flush=True)


def main(argv: list[str]) -> int:
    """Exit code 0: all loops of the list have ended; 2: nothing to do."""
    o = parser().parse_args(argv)
    if o.evidence is not None:
        for line in lines_of_evidence(o.evidence, o.seed):
            print(line, flush=True)
        return 0
    path = o.journal or cache() / "investigate.jsonl"
    cases = cases_of(o)
    if not cases:
        print("bench-investigate: --count and --nulls leave nothing to do", file=sys.stderr)
        return 2
    if o.no_run:
        known = of_this_code(path, o.seed, o.any_code)
        entries = [known[c.key] for c in cases if c.key in known]
    else:
        entries = run(cases, o.seed, o.minutes, path, say, o.jobs)
    if o.write:
        header = {"command": " ".join(["./flatplank bench-investigate", *argv]), "seed": o.seed}
        write_atomic(o.write, head_of(o.write, TITLE) + page(entries, header))
        publish(o.write.with_suffix(".jsonl.gz"), header, entries)
        print(f"{len(entries)} investigations: {o.write}")
    else:
        print(json.dumps(entries, indent=1) if o.json else "\n".join(lines(entries)))
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
