# SPDX-License-Identifier: Apache-2.0
"""QoS profiles of the bench."""

from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

STREAM = QoSProfile(
    reliability=ReliabilityPolicy.RELIABLE, history=HistoryPolicy.KEEP_LAST, depth=2000
)
"""for samples of which none may be lost; the depth is eight seconds at 250 Hz"""

REFERENCE = QoSProfile(
    reliability=ReliabilityPolicy.RELIABLE,
    history=HistoryPolicy.KEEP_LAST,
    depth=2000,
    deadline=Duration(nanoseconds=100_000_000),
)
"""for references; the drive checks their age by the stamps, the deadline is only for ROS tools"""

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
"""for readers that need only the newest sample and must not delay the writer"""
