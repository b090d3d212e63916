# SPDX-License-Identifier: Apache-2.0
"""The command line that the benchmarks share: options in, numbers out."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Mapping, Sequence
from typing import Any

Work = Callable[[argparse.Namespace], Mapping[str, Any]]


def command(text: str | None, work: Work, **options: Any) -> Callable[..., None]:
    """`main(arguments)` that prints what `work` measures, as lines or with --json.

    `options` by name: a number is the default of `--name`, a type that of a positional argument.
    """

    def main(arguments: Sequence[str] | None = None) -> None:
        """Print the numbers."""
        parser = argparse.ArgumentParser(description=text)
        for name, value in options.items():
            if isinstance(value, type):
                parser.add_argument(name, type=value)
            else:
                parser.add_argument(f"--{name}", type=type(value), default=value)
        parser.add_argument("--json", action="store_true", help="print JSON for programs")
        chosen = parser.parse_args(arguments)
        numbers = work(chosen)
        if chosen.json:
            print(json.dumps(dict(numbers)))
            return
        for name, value in numbers.items():
            print(f"{name:24s} {value:.6g}")

    return main
