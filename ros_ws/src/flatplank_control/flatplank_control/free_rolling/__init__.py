# SPDX-License-Identifier: Apache-2.0
"""Free-rolling controller: drives the wheel so that the longitudinal force is small."""

from flatplank_control.free_rolling.controller import ControllerState, FreeRollingController
from flatplank_control.free_rolling.params import FreeRollingParameters

__all__ = ["ControllerState", "FreeRollingController", "FreeRollingParameters"]
