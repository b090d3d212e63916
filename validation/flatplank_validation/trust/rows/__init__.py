# SPDX-License-Identifier: Apache-2.0
"""One module per subject; each function with the decorator `row` is a row of the table."""
