# SPDX-License-Identifier: Apache-2.0
"""Command-line parser of the verbs, which reports an error in one line."""

from __future__ import annotations

import argparse
import re
from typing import NoReturn

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


class Parser(argparse.ArgumentParser):
    """Parser that prints an error as one line on stderr, without the usage; exit code 2."""

    def error(self, message: str) -> NoReturn:
        """Print the error and how to list the options; raise SystemExit with code 2."""
        line = " ".join(message.split())
        self.exit(2, f"{self.prog}: {line}; `{self.prog} --help` lists the options\n")
