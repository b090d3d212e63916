# SPDX-License-Identifier: Apache-2.0
"""The thesis beside ours: its matrix measured on the twin, and every figure, table and number
of its results beside the same of ours."""
