# SPDX-License-Identifier: Apache-2.0
"""ROS shell of the page."""
