# SPDX-License-Identifier: Apache-2.0
"""The defects of the machine, by part (thesis, chapter 3)."""
