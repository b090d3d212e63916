# SPDX-License-Identifier: Apache-2.0
"""The description of a measurement: sample table, run record, files, and limits of the machine."""
