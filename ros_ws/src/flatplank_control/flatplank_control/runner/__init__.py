# SPDX-License-Identifier: Apache-2.0
"""Measurement procedures, independent of the bench that performs them."""
