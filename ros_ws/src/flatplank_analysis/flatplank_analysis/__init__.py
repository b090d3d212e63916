# SPDX-License-Identifier: Apache-2.0
"""Analysis of flat plank measurements: bags -> tables -> models -> comparison -> report."""
