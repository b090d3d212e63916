# SPDX-License-Identifier: Apache-2.0
"""What is left and in no library, as a new effect file.

The effect is proposed, not yet confirmed.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from flatplank_analysis.cli import common, loop
from flatplank_analysis.effects.grammar.file import SUFFIX
from flatplank_analysis.proposal.propose import PROPOSED, Proposal, propose
from flatplank_data.errors import FlatplankError
from flatplank_data.files import write_atomic
from flatplank_data.wording import sized


def main(argv: Sequence[str] | None = None) -> int:
    """`flatplank propose DIR [--out FILE] [--model FILE] [--effects FILE]
    [--report DIR] [--json]`."""
    parser = loop.loop_parser("propose", __doc__, sweeps=True)
    parser.add_argument(
        "--out", metavar="FILE", help="the effect file; default: proposed_NAME.yaml in DIR"
    )
    parser.add_argument("--report", metavar="DIR", help="write a page: curve, form and file")
    arguments = parser.parse_args(argv)
    return common.run_or_report_nothing_usable("propose", lambda: _run(arguments))


def _run(arguments: argparse.Namespace) -> int:
    if arguments.out:
        _require_new(Path(arguments.out))
    if arguments.report:
        loop.require_folder(Path(arguments.report))
    session, model = loop.open_to_look(arguments, own=True)
    result = propose(session, model, loop.progress)
    loop.progress_done()
    path = None
    if result.verdict == PROPOSED:
        path = Path(arguments.out) if arguments.out else _place(arguments.folder, result.name)
        _require_new(path)
        write_atomic(path, result.text)
    if arguments.json:
        common.print_json(result.to_dict() | {"file": str(path) if path else None})
    else:
        print("\n".join(text_of(result, _named(arguments), path, session.force)))
    if arguments.report:
        from flatplank_analysis.proposal.picture import write_proposal

        page = write_proposal(result, Path(arguments.report), arguments.folder, session.about)
        print(f"report: {page}", file=sys.stderr if arguments.json else sys.stdout)
    return 0


def _named(arguments: argparse.Namespace) -> str:
    """Campaign or sweeps as the next command names them, with their tire file."""
    tir = f" --tir {arguments.tir}" if arguments.tir else ""
    return " ".join([arguments.folder, *arguments.more]) + tir


def _place(folder: str, name: str) -> Path:
    path = Path(folder)
    there = path.parent if path.is_file() else path
    writable = "://" not in folder and os.access(there, os.W_OK)
    return (there if writable else Path()) / f"{name}{SUFFIX}"


def _require_new(path: Path) -> None:
    """Raise for an existing file, which somebody may have edited."""
    loop.require_file(path)
    if path.exists():
        raise FlatplankError(
            "is there already", str(path), "use it, move it away, or choose another: --out FILE"
        )


def text_of(result: Proposal, folder: str, path: Path | None, force: str) -> list[str]:
    """The result as text; force: whose error is told."""
    if result.sentence is None or result.numbers is None:
        return [f"nothing to propose ({result.reason})", f"{result.seconds:.1f} s"]
    n, assured = result.numbers, result.outcome
    lines = [
        f"verdict: {result.verdict} ({result.sentence.words()})",
        f"size {sized(n['size'], n['interval'], n['unit'])}",
        f"error of {force} {n['rmse_before']:.1f} -> {n['rmse']:.1f} N, floor {n['floor']:.1f} N; "
        f"held out by condition {n['held_out']:.1f} N, by level {n['held_out_level']:.1f} N",
    ]
    if assured is not None and assured.confused:
        others = "; ".join(t.sentence.words() for t in assured.confused[:3])
        lines.append(f"class: {others} cannot be told from it here")
    lines += [f"doubt: {d}" for d in n["doubts"]]
    lines += [
        f"written to {path}; read it, then",
        f"  flatplank add {result.name} {folder} --effects {path}",
        f"  flatplank confirm {path} {folder} --with NEW_RUNS",
        f"{result.seconds:.1f} s",
    ]
    return lines
