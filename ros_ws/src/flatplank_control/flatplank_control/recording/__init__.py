# SPDX-License-Identifier: Apache-2.0
"""Measurements on disk: one rosbag2 MCAP bag and one run record each; no ROS needed."""
