# SPDX-License-Identifier: Apache-2.0
"""The EtherCAT bus of the bench: bus file, master and emulator. No rclpy in here."""
