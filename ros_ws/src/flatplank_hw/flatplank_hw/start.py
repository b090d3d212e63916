# SPDX-License-Identifier: Apache-2.0
"""The programs that `ros2 run` starts: a node is imported where Ctrl-C is no traceback."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from functools import partial
from importlib import import_module

STOPPED = 130
"""exit code of a program that Ctrl-C ended"""


def starter(package: str) -> Callable[[str], Callable[[], int]]:
    """What finds the program of a node of a package by the node's name."""
    return lambda name: partial(_run, f"{package}.nodes.{name}")


def _run(module: str) -> int:
    # nothing is open yet that had to be closed; the node takes the signal over
    signal.signal(signal.SIGINT, lambda _number, _frame: os._exit(STOPPED))
    return import_module(module).main()


__getattr__ = starter("flatplank_hw")
