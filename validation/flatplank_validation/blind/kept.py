# SPDX-License-Identifier: Apache-2.0
"""Numbers that take seconds to compute, kept in a text file: one line each."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path


def kept(path: Path, key: str, compute: Callable[[], float]) -> float:
    """The number of a key; computed and appended when the file lacks it. A truncated line is
    ignored."""
    if path.is_file():
        for line in path.read_text(encoding="utf-8").splitlines():
            if line.startswith(key + " ") and line.endswith(";"):
                return float(line.split()[1])
    found = compute()
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a", encoding="utf-8") as stream:
        stream.write(f"{key} {found!r} ;\n")
    return found
