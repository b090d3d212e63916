# SPDX-License-Identifier: Apache-2.0
"""ROS shells of the simulated bench."""
