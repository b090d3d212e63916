# SPDX-License-Identifier: Apache-2.0
"""Starting our own programs as child processes, however this package came to be importable."""

from __future__ import annotations

import os
from pathlib import Path


def environment(*more: Path) -> dict[str, str]:
    """This process's environment, with this package, and more folders that packages lie in, in
    front of the child's module path.
    """
    folders = [*map(str, more), str(Path(__file__).parents[2])]
    before = os.environ.get("PYTHONPATH", "")
    path = ":".join([*folders, before] if before else folders)
    return {**os.environ, "PYTHONPATH": path}
