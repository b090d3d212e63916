# SPDX-License-Identifier: Apache-2.0
"""Free-rolling controller: the wheel is driven so that the tire hardly pulls."""

from flatplank_control.free_rolling.controller import ControllerState, FreeRollingController
from flatplank_control.free_rolling.params import FreeRollingParameters

__all__ = ["ControllerState", "FreeRollingController", "FreeRollingParameters"]
