# SPDX-License-Identifier: Apache-2.0
"""Work that kills its process, or not: light to import, since every worker does."""

from __future__ import annotations

import os
import signal
from pathlib import Path


def dies_once(path: str) -> int:
    """The number in the file's name; item 2 dies the first time that it is called."""
    flag = Path(path)
    if flag.name == "2" and not flag.exists():
        flag.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return int(flag.name)


def dies(_item: int) -> None:
    """Never returns."""
    os.kill(os.getpid(), signal.SIGKILL)


def squared(number: int, refused: int = -1) -> int:
    """The square of a number; ValueError for the refused one."""
    if number == refused:
        raise ValueError(f"no {number}")
    return number * number
