# SPDX-License-Identifier: Apache-2.0
"""Do new runs confirm a proposed effect, in size and error?"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from flatplank_analysis.cli import common, loop
from flatplank_analysis.effects.registry import SUFFIXES, load_file
from flatplank_analysis.proposal.confirm import (
    Confirmation,
    confirm,
    fit_with_effect,
    interval_of,
    new_sessions,
)
from flatplank_data.errors import FlatplankError
from flatplank_data.wording import sized, span


def main(argv: Sequence[str] | None = None) -> int:
    """`flatplank confirm NAME_OR_FILE DIR --with NEW_RUNS... [--model FILE] [--json]`."""
    parser = loop.loop_parser("confirm", __doc__, effect=True, sweeps=True)
    parser.add_argument(
        "--with", dest="new", metavar="NEW_RUNS", nargs="+", required=True,
        help="folders of runs that took no part in the search",
    )  # fmt: skip
    arguments = parser.parse_args(argv)
    return common.run_or_report_nothing_usable("confirm", lambda: _run(arguments))


def _run(arguments: argparse.Namespace) -> int:
    if arguments.folder is None:
        raise FlatplankError("no campaign", "confirm", "name the campaign folder: DIR")
    arguments.effects = common.effect_files(arguments)
    name, files = _effect(arguments.effect, arguments.folder)
    arguments.effects += files
    session, model = loop.open_to_look(arguments, own=True)
    if name not in session.effects:
        raise FlatplankError(f"no effect '{name}'", "confirm", "name the file of the proposal")
    if session.effects[name].file:
        interval_of(session.effects[name])
    mapping = common.read_mapping(arguments.mapping)
    sets = new_sessions(session, arguments.new, mapping)
    for _, new in sets:
        common.print_problems(new.campaign.problems)
    loop.progress("fit of the first campaign", 0.3)
    fitted = fit_with_effect(session, model, name)
    result = confirm(session, fitted, name, sets)
    loop.progress_done()
    if arguments.json:
        common.print_json(result.to_dict())
    else:
        print("\n".join(text_of(result, session.force)))
    return 0


def _effect(given: str, folder: str) -> tuple[str, list[str]]:
    """Identifier and file of an effect, given as a file or as a name in the campaign folder."""
    path = Path(given)
    if path.suffix in SUFFIXES:
        return load_file(path)[0].identifier, [given]
    there = [Path(folder) / f"{given}{suffix}" for suffix in SUFFIXES]
    return given, [str(file) for file in there if file.is_file()][:1]


def text_of(result: Confirmation, force: str) -> list[str]:
    """The result as text; force: whose error is told."""
    proposed = span(*result.interval, result.unit)
    lines = [f"verdict: {result.verdict} ({result.name}, {proposed} proposed)"]
    for c in result.checked:
        remarks = "; ".join(c.reasons) or "agrees"
        size = sized(c.size, (c.size - c.half, c.size + c.half), result.unit)
        lines.append(
            f"{c.folder}, {c.runs} runs: {size}, error of {force} {c.error_before:.1f} -> "
            f"{c.error:.1f} N, at most {c.limit:.1f} N: {remarks}"
        )
    return lines
