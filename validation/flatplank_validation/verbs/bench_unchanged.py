# SPDX-License-Identifier: Apache-2.0
"""What must not change, beside another version.

Names, formats, samples and verdicts.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from flatplank_data.arguments import Parser
from flatplank_data.errors import FlatplankError
from flatplank_data.files import read_text, write_atomic
from flatplank_validation.unchanged.compare import differences, table

PARTS = ("verbs", "messages", "topics", "effects", "formats", "files", "twin", "diagnosis")


def parser() -> Parser:
    p = Parser(prog="flatplank bench-unchanged", description=__doc__)
    p.add_argument("parts", nargs="*", help=f"some of {', '.join(PARTS)}; default: all")
    p.add_argument("--write", type=Path, metavar="FILE", help="keep this version's facts")
    p.add_argument("--against", type=Path, metavar="FILE", help="facts of another version")
    p.add_argument(
        "--campaigns", type=int, default=60, metavar="N", help="of the blind test; default: 60"
    )
    p.add_argument("--folder", type=Path, action="append", default=[], help="diagnosed, too")
    p.add_argument("--jobs", type=int, default=1, help="processes of the diagnosis")
    return p


def main(argv: list[str]) -> int:
    """Exit code 0: no fact of the other version is missing or changed."""
    p = parser()
    o = p.parse_args(argv)
    for part in o.parts:
        if part not in PARTS:
            p.error(f"unknown part '{part}'; known are {', '.join(PARTS)}")
    before = _kept(o.against) if o.against else None
    from flatplank_validation.unchanged import facts

    now = {part: facts.PARTS[part](o) for part in o.parts or PARTS}
    if o.write:
        write_atomic(o.write, json.dumps(now, indent=1) + "\n")
    print(table(now, before))
    return int(before is not None and any(differences(before, now).values()))


def _kept(file: Path) -> dict[str, Any]:
    try:
        return json.loads(read_text(file))
    except ValueError as error:
        what = f"holds no facts ({error})"
        raise FlatplankError(what, str(file), "make it with --write") from None


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
