# SPDX-License-Identifier: Apache-2.0
"""Compiled inner loops whose cache follows the source of all of them.

Numba notices a change in the file of the cached function only; these call each other across files,
so the cache folder carries a hash of the files. The plant does the same on its own
(`flatplank_sim.plant.compiling`): it shares no code with what is fitted to it.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from importlib.util import cache_from_source
from pathlib import Path
from typing import Any

from numba import njit
from numba.core import config

FILES = ("kernel.py", "vector.py")
"""whose functions call each other"""
FAST = dict(nogil=True, error_model="numpy", fastmath={"contract", "arcp", "nsz"})
"""no checks for division by zero; what is not finite is found by the engine"""
inner = njit(**FAST)
"""A function that other compiled ones call."""
inline = njit(forceinline=True, **FAST)
"""One that is called for every element: a call inside a loop keeps it from being vectorised."""


def folder() -> str:
    """Where numba keeps its cache, or beside the byte code, in a folder of these sources; what
    numba says where that may not be written."""
    digest = hashlib.sha256()
    for name in FILES:
        digest.update((Path(__file__).parent / name).read_bytes())
    root = Path(config.CACHE_DIR or Path(cache_from_source(__file__)).parent)
    made = root / f"contact_patch-{digest.hexdigest()[:16]}"
    try:
        made.mkdir(parents=True, exist_ok=True)
    except OSError:
        return config.CACHE_DIR
    return str(made) if os.access(made, os.W_OK) else config.CACHE_DIR


def entry(function: Callable[..., Any]) -> Any:
    """One that Python calls: compiled once, kept on disk."""
    before = config.CACHE_DIR
    config.CACHE_DIR = folder()
    try:
        return njit(cache=True, **FAST)(function)
    finally:
        config.CACHE_DIR = before
