# SPDX-License-Identifier: Apache-2.0
"""The runs of all campaigns below a folder in one table: where they are, quality, verdicts."""
