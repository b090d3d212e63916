# SPDX-License-Identifier: Apache-2.0
"""Several nodes in one process:
`python -m flatplank_control.nodes.loop NAME=MODULE ... --ros-args ...`.

Samples go from one node to the other without the middleware.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from contextlib import ExitStack
from functools import partial
from importlib import import_module
from typing import Any

from flatplank_hw.nodes.local import ignore_local_endpoints
from flatplank_hw.nodes.running import run_nodes

ROS_ARGS = "--ros-args"


def makers(words: Iterable[str]) -> list[Callable[..., Any]]:
    """Functions that make the nodes, from words `NAME=MODULE`."""
    pairs = [word.partition("=") for word in words]
    return [partial(import_module(module).NODE, name) for name, _, module in pairs]


def main(argv: list[str] | None = None) -> int:
    """Run the nodes until they are told to end; the exit code of a node that ends by itself."""
    given = (sys.argv if argv is None else argv)[1:]
    words, ros = given[: given.index(ROS_ARGS)], given[given.index(ROS_ARGS) :]
    with ExitStack() as stack:
        try:
            local = stack.enter_context(ignore_local_endpoints())
        except ValueError as error:
            print(error, file=sys.stderr)
            return 1
        return run_nodes(makers(words), ros, local=local)


if __name__ == "__main__":
    raise SystemExit(main())
