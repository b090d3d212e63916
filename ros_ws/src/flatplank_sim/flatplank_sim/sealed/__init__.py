# SPDX-License-Identifier: Apache-2.0
"""Sealed challenges: campaigns with a hidden effect, whose answer the analysis never reads."""
