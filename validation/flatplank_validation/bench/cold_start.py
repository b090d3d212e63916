# SPDX-License-Identifier: Apache-2.0
"""Reproduces the start of a bench on a new computer: without caches, with other work running."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import flatplank_analysis
import flatplank_control
import flatplank_hw

BUSY = "while True: pass"


def without_byte_code(folder: Path) -> dict[str, str]:
    """Environment without cached byte code and compiled kernels; both go to `folder`."""
    return {
        "PYTHONPYCACHEPREFIX": str(folder / "byte_code"),
        "NUMBA_CACHE_DIR": str(folder / "kernels"),
    }


def forget_files() -> int:
    """Drop the files of the environment and our packages from the page cache.

    Returns the number of files; those that a running process has mapped stay in memory.
    """
    packages = [flatplank_analysis, flatplank_control, flatplank_hw]
    roots = [Path(sys.prefix, "lib"), *(Path(package.__path__[0]) for package in packages)]
    files = [file for root in roots for file in root.rglob("*") if file.is_file()]
    for file in files:
        with suppress(OSError):
            handle = os.open(file, os.O_RDONLY)
            try:
                os.posix_fadvise(handle, 0, 0, os.POSIX_FADV_DONTNEED)
            finally:
                os.close(handle)
    return len(files)


@contextmanager
def busy(processes: int) -> Iterator[None]:
    """Start `processes` processes that only compute."""
    running = [subprocess.Popen([sys.executable, "-S", "-c", BUSY]) for _ in range(processes)]
    try:
        yield
    finally:
        for process in running:
            process.kill()
            process.wait()
