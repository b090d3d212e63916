# SPDX-License-Identifier: Apache-2.0
"""The EtherCAT bus of the bench: bus file, import of vendor files, master. Without rclpy."""
