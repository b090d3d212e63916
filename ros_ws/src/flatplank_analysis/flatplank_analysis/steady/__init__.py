# SPDX-License-Identifier: Apache-2.0
"""Steady quantities of a tire and of the machine, each from its own kind of measurement."""
