# SPDX-License-Identifier: Apache-2.0
"""QoS profiles of the bench."""

from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

STREAM = QoSProfile(
    reliability=ReliabilityPolicy.RELIABLE, history=HistoryPolicy.KEEP_LAST, depth=2000
)
"""no sample may be lost: depth for eight seconds at 250 Hz"""

REFERENCE = QoSProfile(
    reliability=ReliabilityPolicy.RELIABLE,
    history=HistoryPolicy.KEEP_LAST,
    depth=2000,
    deadline=Duration(nanoseconds=100_000_000),
)
"""A set-point older than 100 ms is stale: the drive checks the stamps, the deadline is for ROS
tools.
"""

LATCHED = QoSProfile(
    reliability=ReliabilityPolicy.RELIABLE,
    history=HistoryPolicy.KEEP_LAST,
    depth=1,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)
"""for messages sent once that later subscribers need, too"""

LATEST = QoSProfile(
    reliability=ReliabilityPolicy.BEST_EFFORT, history=HistoryPolicy.KEEP_LAST, depth=1
)
"""for readers that need only the newest sample, and for whom no writer waits"""
