# SPDX-License-Identifier: Apache-2.0
"""Frames of a running bench, for rviz and Foxglove: `ros2 launch flatplank_control
display.launch.py`."""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from launch import LaunchDescription

JOINT_STATES = ("encoders/joint_states", "measurement_hub/joint_states")
"""topics that say where the joints are"""
RATE_HZ = 25
"""rate of the frames [Hz]"""


def generate_launch_description() -> LaunchDescription:
    share = Path(get_package_share_directory("flatplank_control"))
    urdf = (share / "config" / "bench.urdf").read_text(encoding="utf-8")
    namespace = LaunchConfiguration("namespace")
    joints = {"source_list": list(JOINT_STATES), "rate": RATE_HZ, "robot_description": urdf}
    return LaunchDescription([
        DeclareLaunchArgument("namespace", default_value="", description="that of the bench"),
        Node(package="joint_state_publisher", executable="joint_state_publisher",
             namespace=namespace, parameters=[joints]),
        Node(package="robot_state_publisher", executable="robot_state_publisher",
             namespace=namespace, parameters=[{"robot_description": urdf}]),
    ])  # fmt: skip
