# SPDX-License-Identifier: Apache-2.0
"""ROS nodes around the hardware cores."""
