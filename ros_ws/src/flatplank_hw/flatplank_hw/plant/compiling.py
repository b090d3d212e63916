# SPDX-License-Identifier: Apache-2.0
"""Compiled inner loops whose cache follows the source of *all* kernels.

Numba notices a change in the file of the cached function only; the kernels here call each other
across files, so the cache folder carries a hash of the whole package instead.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
from numba.core import config as numba_config

_FOLDER = Path(__file__).parent


def _source_stamp() -> str:
    digest = hashlib.sha256(numba.__version__.encode())
    for file in sorted(_FOLDER.glob("*.py")):
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


def _cache_root() -> Path:
    """Beside the sources when they may be written, else in the user's cache."""
    beside = _FOLDER / "__pycache__"
    if os.access(beside if beside.exists() else _FOLDER, os.W_OK):
        return beside
    base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(base) / "flatplank"


def _entry(function: Callable[..., Any]) -> Any:
    before = numba_config.CACHE_DIR
    numba_config.CACHE_DIR = str(_cache_root() / f"kernels-{_source_stamp()}")
    try:
        return numba.njit(cache=True, nogil=True, error_model="numpy")(function)
    finally:
        numba_config.CACHE_DIR = before


inner = numba.njit(nogil=True, error_model="numpy", inline="never")
"""A kernel that other kernels call."""

entry = _entry
"""A kernel that Python calls: compiled once, kept on disk."""
