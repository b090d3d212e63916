# SPDX-License-Identifier: Apache-2.0
"""A graph that nobody else hears: UDP on the loopback interface, no shared memory.

Fast DDS shares memory between processes by default, and a killed node leaves locks and segments
behind on which others can wait for ever. With discovery range LOCALHOST rmw_fastrtps adds shared
memory whatever FASTDDS_BUILTIN_TRANSPORTS says; only a profile of its own keeps it away.
"""

from __future__ import annotations

import os
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
