# SPDX-License-Identifier: Apache-2.0
"""Fast DDS: keeps the ROS graph on this computer, and removes what killed nodes leave behind.

By default Fast DDS shares memory between processes, and a killed node leaves locks and segments
behind on which others can wait for ever. With discovery range LOCALHOST rmw_fastrtps adds shared
memory whatever the value of FASTDDS_BUILTIN_TRANSPORTS; only an XML profile prevents this."""

from __future__ import annotations

import fcntl
import os
from contextlib import ExitStack
from pathlib import Path

PROFILE = Path(__file__).with_name("loopback.xml")
"""profile for participants that communicate and discover each other on 127.0.0.1 only"""


def loopback_environment() -> dict[str, str]:
    """Environment variables for a graph on this computer only, with any middleware."""
    if "fastrtps" not in os.environ.get("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp"):
        return {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    return {
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "SYSTEM_DEFAULT",
        "FASTRTPS_DEFAULT_PROFILES_FILE": str(PROFILE),
    }


SHARED_MEMORY = Path("/dev/shm")
LOCKS = ("_el", "_sl")
"""suffixes of the lock files that the owners of a segment or port hold while they live"""


def remove_orphans(folder: Path = SHARED_MEMORY) -> list[str]:
    """Remove segments and ports of Fast DDS whose owners are gone, as `fastdds shm clean` does.

    Returns their names.
    """
    names = {lock.name[:-3] for ending in LOCKS for lock in folder.glob(f"fastrtps_*{ending}")}
    return sorted(name for name in names if _remove(folder, name))


def _remove(folder: Path, name: str) -> bool:
    """Remove a segment or port with its locks, unless a process holds one; true when removed."""
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
