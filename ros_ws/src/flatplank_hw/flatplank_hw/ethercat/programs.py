# SPDX-License-Identifier: Apache-2.0
"""Starting our own programs as child processes, however this package came to be importable."""

from __future__ import annotations

import os
from pathlib import Path


def environment() -> dict[str, str]:
    """This process's environment, with this package in front of the child's module path."""
    here = str(Path(__file__).parents[2])
    before = os.environ.get("PYTHONPATH", "")
    return {**os.environ, "PYTHONPATH": f"{here}:{before}" if before else here}
