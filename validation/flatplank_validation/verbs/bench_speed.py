# SPDX-License-Identifier: Apache-2.0
"""The numbers that the bench must reach, beside their goals."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from flatplank_data.arguments import Parser

PARTS = ("margins", "twin", "lockstep", "realtime", "ethercat", "start", "panel")


def main(argv: list[str]) -> int:
    """Exit code 0: every part ran."""
    p = Parser(prog="flatplank bench-speed", description=__doc__)
    p.add_argument("parts", nargs="*", help=f"some of {', '.join(PARTS)}; default: all")
    p.add_argument("--minutes", type=float, help="how long the pages are watched; default: 2")
    p.add_argument(
        "--write", action="store_true", help="the table of start into docs/tutorial/start.md"
    )
    o = p.parse_args(argv)
    for part in o.parts:
        if part not in PARTS:
            p.error(f"unknown part '{part}'; known are {', '.join(PARTS)}")
    if o.minutes is not None and o.minutes < 1.0:
        p.error(f"--minutes is {o.minutes:g}; rates are taken over whole minutes: give 1 or more")
    words = {
        "panel": [] if o.minutes is None else [f"{o.minutes:g}"],
        "start": ["--write"] if o.write else [],
    }
    folder = Path(__file__).resolve().parents[2] / "benchmarks"
    failed = False
    for part in o.parts or PARTS:
        command = [sys.executable, str(folder / f"{part}.py"), *words.get(part, [])]
        failed |= subprocess.run(command, check=False).returncode != 0
    return int(failed)
