# SPDX-License-Identifier: Apache-2.0
"""Several nodes in one process:
`python -m flatplank_control.nodes.loop NAME=MODULE ... --beside NAME=MODULE ... --ros-args ...`.

Samples go from one node of the loop to the other without the middleware. Nodes beside the loop are
ordinary participants in the same process.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from contextlib import ExitStack
from functools import partial
from importlib import import_module
from typing import Any

from flatplank_control.bench.processes import BESIDE
from flatplank_hw.nodes.local import ignore_local_endpoints
from flatplank_hw.nodes.support import run_nodes

ROS_ARGS = "--ros-args"


def makers(words: Iterable[str]) -> list[Callable[..., Any]]:
    """Functions that make the nodes, from words `NAME=MODULE`."""
    pairs = [word.partition("=") for word in words]
    return [partial(import_module(module).NODE, name) for name, _, module in pairs]


def main(argv: list[str] | None = None) -> int:
    """Run the nodes until they are told to end; the exit code of a node that ends by itself."""
    given = (sys.argv if argv is None else argv)[1:]
    words, ros = given[: given.index(ROS_ARGS)], given[given.index(ROS_ARGS) :]
    loop = words[: words.index(BESIDE)] if BESIDE in words else words
    with ExitStack() as stack:
        try:
            local = stack.enter_context(ignore_local_endpoints())
        except ValueError as error:
            print(error, file=sys.stderr)
            return 1
        return run_nodes(makers(loop), ros, local=local, beside=makers(words[len(loop) + 1 :]))


if __name__ == "__main__":
    raise SystemExit(main())
