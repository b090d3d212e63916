# SPDX-License-Identifier: Apache-2.0
"""Shared functions of the analysis verbs."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from flatplank_data.arguments import Parser, add_json, json_text
from flatplank_data.errors import FlatplankError, NothingUsableError
from flatplank_data.problem import Problem
from flatplank_tire.numbers import number_of

if TYPE_CHECKING:  # a campaign brings every reader: half a second that not every verb needs
    from flatplank_data.campaign import Campaign

NOTHING_USABLE = 2


def campaign_parser(verb: str, text: str, several: bool = False) -> argparse.ArgumentParser:
    """A parser with the arguments of every verb on a campaign; `several`: on any number."""
    parser = Parser(prog=f"flatplank {verb}", description=text)
    many: dict[str, Any] = {"nargs": "*"} if several else {}
    parser.add_argument("folder", metavar="DIR", help="campaign folder, or an fsspec URL", **many)
    add_json(parser)
    mapping_argument(parser)
    return parser


def mapping_argument(parser: argparse.ArgumentParser) -> None:
    """Add the option `--mapping`."""
    parser.add_argument("--mapping", metavar="FILE", help="YAML with foreign topics or columns")


def effect_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options `--effects` and `--trust`."""
    parser.add_argument(
        "--effects", metavar="FILE", action="append", default=[],
        help="effects of your own: a proposal, or Python that you have allowed to run",
    )  # fmt: skip
    parser.add_argument(
        "--trust", metavar="FILE", action="append", default=[],
        help="the same, and allow this Python file to run as it is now; remembered for you",
    )  # fmt: skip


def effect_files(arguments: argparse.Namespace) -> list[str]:
    """The user's effect files, after consent to those of `--trust`."""
    from flatplank_analysis.effects import consent

    consent.give(arguments.trust)
    return [*arguments.effects, *arguments.trust]


def tire_argument(parser: argparse.ArgumentParser) -> None:
    """Add the option `--tire`."""
    text = "tire record (YAML), or a .tir to start from; default: tire.yaml in DIR, else made "
    parser.add_argument("--tire", metavar="FILE", help=f"{text}from the data, and said")


def parallel_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options `--jobs` and `--scheduler`."""
    parser.add_argument("--jobs", type=int, default=None, help="processes (default: every core)")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="of a Dask cluster, instead")


def load_folder(folder: str, mapping: str | None = None) -> Campaign:
    """The campaign in a folder, with the mapping file when there is one."""
    from flatplank_data.campaign import Campaign

    return Campaign.load(folder, mapping=read_mapping(mapping))


def read_mapping(path: str | None) -> dict[str, Any] | None:
    """Content of a mapping file, None without one."""
    if path is None:
        return None
    from flatplank_data.yaml_text import load_yaml

    found = load_yaml(Path(path).read_bytes(), path)
    if not isinstance(found, dict):
        raise FlatplankError("no mapping", path, "write 'topics:' or 'columns:'")
    return found


def run_or_report_nothing_usable(verb: str, work: Callable[[], int]) -> int:
    """Exit code of `work`; 2 with one line on stderr when no run could be used."""
    try:
        return work()
    except NothingUsableError as error:
        print(f"flatplank {verb}: {error}", file=sys.stderr)
        return NOTHING_USABLE


def print_problems(problems: Iterable[Problem]) -> None:
    """Print problems on stderr, one line each."""
    for problem in problems:
        print(f"warning: {problem}", file=sys.stderr)


def show_progress(done: int, total: int, what: str) -> None:
    """Show how many of all jobs are done, and the last one."""
    progress_line(f"{done}/{total} {what}", "\n" if done == total else "")


def progress_line(text: str, end: str = "") -> None:
    """Print a progress line that is overwritten, on a terminal or in a notebook."""
    if sys.stderr.isatty() or "ipykernel" in sys.modules:
        print(f"\r\x1b[2K{text}", end=end, file=sys.stderr, flush=True)


def print_json(value: Any) -> None:
    """Print strict JSON."""
    print(json_text(value))


def print_rows(header: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print columns of minimal width; numbers are right-aligned."""
    widths = [max(len(row[i]) for row in [header, *rows]) for i in range(len(header))]
    right = [
        all(row[i] in ("", "-") or number_of(row[i]) is not None for row in rows)
        for i in range(len(header))
    ]
    for row in [header, *rows]:
        cells = [
            c.rjust(w) if r else c.ljust(w) for c, w, r in zip(row, widths, right, strict=True)
        ]
        print("  ".join(cells).rstrip())
