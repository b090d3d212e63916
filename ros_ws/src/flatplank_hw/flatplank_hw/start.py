# SPDX-License-Identifier: Apache-2.0
"""Entry points for `ros2 run`; Ctrl-C during the import of a node gives no traceback."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from functools import partial
from importlib import import_module

STOPPED = 130
"""exit code of a program that Ctrl-C ended"""


def starter(package: str) -> Callable[[str], Callable[[], int]]:
    """Return a lookup from node name to its program, for one package."""
    return lambda name: partial(_run, f"{package}.nodes.{name}")


def _run(module: str) -> int:
    # nothing is open yet; the node later installs its own signal handler
    signal.signal(signal.SIGINT, lambda _number, _frame: os._exit(STOPPED))
    return import_module(module).main()


__getattr__ = starter("flatplank_hw")
