# SPDX-License-Identifier: Apache-2.0
"""Fast DDS: a graph that nobody else hears, and what killed nodes leave behind.

Fast DDS shares memory between processes by default, and a killed node leaves locks and segments
behind on which others can wait for ever. With discovery range LOCALHOST rmw_fastrtps adds shared
memory whatever FASTDDS_BUILTIN_TRANSPORTS says; only a profile of its own keeps it away."""

from __future__ import annotations

import fcntl
import os
from contextlib import ExitStack
from pathlib import Path

PROFILE = Path(__file__).with_name("loopback.xml")
"""participants on 127.0.0.1 that look for each other there"""


def loopback() -> dict[str, str]:
    """Environment of such a graph; another middleware stays on this computer by its own means."""
    if "fastrtps" not in os.environ.get("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp"):
        return {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    return {
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "SYSTEM_DEFAULT",
        "FASTRTPS_DEFAULT_PROFILES_FILE": str(PROFILE),
    }


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
