# SPDX-License-Identifier: Apache-2.0
"""The bench's own cores and the simulated plant in one process, without ROS."""
