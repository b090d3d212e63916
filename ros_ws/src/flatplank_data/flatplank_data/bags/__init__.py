# SPDX-License-Identifier: Apache-2.0
"""Reads rosbag2 bags without ROS: only the topics that are needed, many messages at a time."""
