# SPDX-License-Identifier: Apache-2.0
"""The defects of the machine, by the part that has them (thesis, chapter 3)."""
