# SPDX-License-Identifier: Apache-2.0
"""Work that kills its process, once: light to import, since every worker does."""

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
