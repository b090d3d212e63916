# SPDX-License-Identifier: Apache-2.0
"""Constant vertical force on a driven vertical axis; off by default."""

from flatplank_control.load_control.controller import LoadController, LoadParameters

__all__ = ["LoadController", "LoadParameters"]
