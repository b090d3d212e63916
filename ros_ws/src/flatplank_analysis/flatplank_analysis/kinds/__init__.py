# SPDX-License-Identifier: Apache-2.0
"""Models of the measurements without a slip step: one file per kind."""
