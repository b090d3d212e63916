# SPDX-License-Identifier: Apache-2.0
"""Command-line parser of the verbs, which reports an error in one line."""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from typing import Any, NoReturn

_WORD = r"[A-Za-z_][A-Za-z0-9_]*"


def namespace_of(text: str) -> str:
    """ROS namespace of a bench: empty for `/`, else as in `/bench2`; ValueError."""
    found = text.strip("/")
    if found and not re.fullmatch(f"{_WORD}(/{_WORD})*", found):
        raise ValueError(
            f"'{text}' is no ROS namespace: letters, digits and _, as in bench2 or hall/bench2"
        )
    return f"/{found}" if found else ""


def add_namespace(parser: argparse.ArgumentParser) -> None:
    """Add the option `--namespace` of a verb that speaks to a bench."""

    def checked(text: str) -> str:
        try:
            return namespace_of(text)
        except ValueError as error:
            raise argparse.ArgumentTypeError(str(error)) from None

    parser.add_argument(
        "--namespace", type=checked, default="", help="ROS namespace of the bench, as in bench2"
    )


def add_json(parser: argparse.ArgumentParser) -> None:
    """Add the option `--json` of a verb."""
    parser.add_argument("--json", action="store_true", help="print JSON for programs")


@contextmanager
def for_programs(wanted: bool) -> Iterator[dict[str, Any]]:
    """A dictionary for the result of a verb, printed as JSON at the end where it is wanted; what
    the verb prints for people goes to stderr then."""
    found: dict[str, Any] = {}
    if not wanted:
        yield found
        return
    with redirect_stdout(sys.stderr):
        yield found
    print(json_text(found))


def json_text(value: Any) -> str:
    """Strict JSON; ValueError for a number that is not finite."""
    return json.dumps(value, indent=1, allow_nan=False)


class Parser(argparse.ArgumentParser):
    """Parser that prints an error as one line on stderr, without the usage; exit code 2."""

    def error(self, message: str) -> NoReturn:
        """Print the error and how to list the options; raise SystemExit with code 2."""
        line = " ".join(message.split())
        self.exit(2, f"{self.prog}: {line}; `{self.prog} --help` lists the options\n")
