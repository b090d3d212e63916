# SPDX-License-Identifier: Apache-2.0
"""How good the loop is that chooses its own runs."""
