# SPDX-License-Identifier: Apache-2.0
"""Finds files of our packages, installed or in the source tree."""

from __future__ import annotations

import os
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from flatplank_data.params import load_parameters


def config_file(package: str, name: str) -> Path | None:
    """Path of `config/name` of a package; None when it has no such file."""
    for base in _bases(package):
        path = base / "config" / name
        if path.is_file():
            return path
    return None


def packaged_parameters(package: str, node: str) -> dict[str, Any]:
    """Parameters of a node in the file that its package has for it; none without such a file."""
    path = config_file(package, f"{node}.yaml")
    return load_parameters(path, node) if path else {}


def _bases(package: str):
    for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        if prefix:
            yield Path(prefix) / "share" / package
    spec = find_spec(package)
    if spec and spec.origin:
        yield Path(spec.origin).parent.parent
