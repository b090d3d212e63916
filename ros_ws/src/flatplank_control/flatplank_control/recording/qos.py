# SPDX-License-Identifier: Apache-2.0
"""Quality of service of a recorded topic, in the form that rosbag2 stores."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import yaml

_INFINITE_NS = 2**63 - 1


@dataclass(frozen=True)
class Qos:
    """Offered profile; the words are those of `ros2 topic info --verbose` in lower case."""

    depth: int = 10
    reliability: str = "reliable"
    durability: str = "volatile"
    history: str = "keep_last"
    deadline_ns: int = _INFINITE_NS
    """[ns]"""


STREAM = Qos(depth=2000)
LATCHED = Qos(depth=1, durability="transient_local")
REFERENCE = Qos(depth=2000, deadline_ns=100_000_000)
HEALTH = Qos(depth=10)


def _duration(ns: int) -> dict[str, int]:
    return {"sec": ns // 1_000_000_000, "nsec": ns % 1_000_000_000}


def qos_list(profiles: Sequence[Qos]) -> list[dict[str, Any]]:
    """Profiles as in `metadata.yaml`, version 9."""
    return [
        {
            "history": qos.history,
            "depth": qos.depth,
            "reliability": qos.reliability,
            "durability": qos.durability,
            "deadline": _duration(qos.deadline_ns),
            "lifespan": _duration(_INFINITE_NS),
            "liveliness": "automatic",
            "liveliness_lease_duration": _duration(_INFINITE_NS),
            "avoid_ros_namespace_conventions": False,
        }
        for qos in profiles
    ]


def qos_text(profiles: Sequence[Qos]) -> str:
    """Profiles as in the metadata of an MCAP channel."""
    return yaml.safe_dump(qos_list(profiles), sort_keys=False).strip()
