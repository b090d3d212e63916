# SPDX-License-Identifier: Apache-2.0
"""Writes measurements to disk without ROS: one rosbag2 MCAP bag and one run record each."""
