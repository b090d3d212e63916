# SPDX-License-Identifier: Apache-2.0
"""Pages of docs/ that are made of the code."""
