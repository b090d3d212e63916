# SPDX-License-Identifier: Apache-2.0
"""Simulated bench: plant and defects, EtherCAT emulator, twin, sealed challenges."""
