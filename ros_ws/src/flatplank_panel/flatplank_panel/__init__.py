# SPDX-License-Identifier: Apache-2.0
"""The operator's page: state, validation and views, without ROS except in `nodes/panel.py`."""
