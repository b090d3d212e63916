# SPDX-License-Identifier: Apache-2.0
"""Measurements on disk: one rosbag2 MCAP bag and one run record each; no ROS needed."""

from flatplank_control.recording.bag_writer import BagWriter, TopicSpec
from flatplank_control.recording.cdr_layout import CdrLayout
from flatplank_control.recording.recovery import mend
from flatplank_control.recording.session import RecordingSession
from flatplank_control.recording.twin_writer import TwinWriter
from flatplank_control.recording.typestore import typestore

__all__ = [
    "BagWriter",
    "CdrLayout",
    "RecordingSession",
    "TopicSpec",
    "TwinWriter",
    "mend",
    "typestore",
]
