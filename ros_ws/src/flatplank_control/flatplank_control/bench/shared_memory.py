# SPDX-License-Identifier: Apache-2.0
"""Shared memory of killed nodes: Fast DDS leaves it behind."""

from __future__ import annotations

import fcntl
from contextlib import ExitStack
from pathlib import Path

SHARED_MEMORY = Path("/dev/shm")
LOCKS = ("_el", "_sl")
"""endings of the files that an owner, or those who share a port, hold locked while they live"""


def remove_orphans(folder: Path = SHARED_MEMORY) -> list[str]:
    """Remove segments and ports of Fast DDS whose owners are gone, as `fastdds shm clean` does.

    Returns their names.
    """
    names = {lock.name[:-3] for ending in LOCKS for lock in folder.glob(f"fastrtps_*{ending}")}
    return sorted(name for name in names if _remove(folder, name))


def _remove(folder: Path, name: str) -> bool:
    """Whether nobody held a lock on it; then it is gone."""
    locks = [lock for ending in LOCKS if (lock := folder / f"{name}{ending}").exists()]
    with ExitStack() as held:
        try:
            for lock in locks:
                fcntl.flock(held.enter_context(lock.open("rb")), fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return False
        for file in (folder / name, folder / f"sem.{name}_mutex", *locks):
            file.unlink(missing_ok=True)
    return True
