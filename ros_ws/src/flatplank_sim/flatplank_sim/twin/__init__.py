# SPDX-License-Identifier: Apache-2.0
"""The twin: the cores of the bench and the simulated plant in one process, without ROS."""
