# SPDX-License-Identifier: Apache-2.0
"""Qualities of service of the bench, one place."""

from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

STREAM = QoSProfile(
    reliability=ReliabilityPolicy.RELIABLE, history=HistoryPolicy.KEEP_LAST, depth=2000
)
"""Every sample counts: deep enough for eight seconds at 250 Hz."""

REFERENCE = QoSProfile(
    reliability=ReliabilityPolicy.RELIABLE,
    history=HistoryPolicy.KEEP_LAST,
    depth=2000,
    deadline=Duration(nanoseconds=100_000_000),
)
"""A set-point older than 100 ms is stale; the drive acts on it by the stamps, the deadline tells
tools.
"""

LATCHED = QoSProfile(
    reliability=ReliabilityPolicy.RELIABLE,
    history=HistoryPolicy.KEEP_LAST,
    depth=1,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)
"""For what is said once and must be known to everybody who comes later."""
