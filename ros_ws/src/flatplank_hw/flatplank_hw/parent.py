# SPDX-License-Identifier: Apache-2.0
"""A node that was started for somebody says when it listens, and ends with that one."""

from __future__ import annotations

import ctypes
import os
import signal
from pathlib import Path

END_WITH_PARENT = "FLATPLANK_END_WITH_PARENT"
"""environment: id of the process that the node belongs to"""

STARTED = "FLATPLANK_STARTED"
"""environment: file that the node makes as soon as it listens"""

_PR_SET_PDEATHSIG = 1


def end_with_parent() -> None:
    """Get SIGTERM when the parent named in the environment dies (Linux)."""
    parent = os.environ.get(END_WITH_PARENT)
    if parent is None:
        return
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != int(parent):
        raise SystemExit(f"the process {parent} that started this node is gone")


def tell_started() -> None:
    """Make the file that the environment names, if any."""
    if file := os.environ.get(STARTED):
        Path(file).touch()
