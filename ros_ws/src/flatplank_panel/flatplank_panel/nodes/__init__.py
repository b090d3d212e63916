# SPDX-License-Identifier: Apache-2.0
"""ROS node of the page."""
