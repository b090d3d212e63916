# SPDX-License-Identifier: Apache-2.0
"""What the bench can be trusted with: faults, damage and wrong numbers, counted. `./flatplank
bench-trust` prints the table; a row is a function in `rows/` with the decorator `row`."""
