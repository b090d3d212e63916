# SPDX-License-Identifier: Apache-2.0
"""Compiles kernels with a cache that depends on the source of *all* kernels.

Numba detects a change only in the file of the cached function. The kernels here call each other
across files, so the name of the cache folder contains a hash of the whole package.
"""

from __future__ import annotations

import hashlib
import os
import shutil
from collections.abc import Callable
from importlib.util import cache_from_source
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


def _cache_folder() -> Path | None:
    """Make the cache folder next to the byte code if that is writable, else in the user's cache;
    None when neither is."""
    home = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    name = f"kernels-{_source_stamp()}"
    byte_code = Path(cache_from_source(__file__)).parent
    for root in (byte_code, Path(home) / "flatplank"):
        try:
            (root / name).mkdir(parents=True, exist_ok=True)
        except OSError:
            continue
        if os.access(root / name, os.W_OK):
            _forget_others(root, name)
            return root / name
    return None


def _forget_others(root: Path, name: str) -> None:
    """Remove cached kernels of other source versions."""
    for old in root.glob("kernels-*"):
        if old.name != name:
            shutil.rmtree(old, ignore_errors=True)


_CACHE = _cache_folder()


def _entry(function: Callable[..., Any]) -> Any:
    if _CACHE is None:
        return numba.njit(nogil=True, error_model="numpy")(function)
    before = numba_config.CACHE_DIR
    numba_config.CACHE_DIR = str(_CACHE)
    try:
        return numba.njit(cache=True, nogil=True, error_model="numpy")(function)
    finally:
        numba_config.CACHE_DIR = before


inner = numba.njit(nogil=True, error_model="numpy", inline="never")
"""decorator of a kernel that other kernels call"""

entry = _entry
"""decorator of a kernel that Python calls: compiled once, cached on disk"""
