# SPDX-License-Identifier: Apache-2.0
"""What a measurement is: its table, its record, its files, and what the machine can be set to."""
