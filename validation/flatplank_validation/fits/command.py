# SPDX-License-Identifier: Apache-2.0
"""Common command line of the benchmarks."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from flatplank_data.arguments import add_json

Work = Callable[[argparse.Namespace], Mapping[str, Any]]


def command(text: str | None, work: Work, **options: Any) -> Callable[..., None]:
    """Make a `main(arguments)` that prints the results of `work`, as lines or with --json.

    `options`: a number is the default of option `--name`, a type makes a positional argument.
    """

    def main(arguments: Sequence[str] | None = None) -> None:
        """Print the numbers."""
        parser = argparse.ArgumentParser(description=text)
        for name, value in options.items():
            if isinstance(value, type):
                parser.add_argument(name, type=value)
            else:
                parser.add_argument(f"--{name}", type=type(value), default=value)
        add_json(parser)
        chosen = parser.parse_args(arguments)
        numbers = work(chosen)
        if chosen.json:
            print(json.dumps(dict(numbers)))
            return
        for name, value in numbers.items():
            print(f"{name:24s} {value:.6g}")

    return main
