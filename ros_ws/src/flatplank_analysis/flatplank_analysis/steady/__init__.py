# SPDX-License-Identifier: Apache-2.0
"""Steady quantities of tire and machine, a module for each kind of quantity."""
