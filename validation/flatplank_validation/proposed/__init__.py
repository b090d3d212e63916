# SPDX-License-Identifier: Apache-2.0
"""Test kit for proposals: forces outside the library, in worlds that share no code with it."""
