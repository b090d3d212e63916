# SPDX-License-Identifier: Apache-2.0
"""The operator's page: state, validation and views; knows no ROS (`nodes/panel.py` does)."""
