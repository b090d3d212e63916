# SPDX-License-Identifier: Apache-2.0
"""One drive: CiA 402, operation modes, safety rules."""

from flatplank_hw.drive.axis import AxisDrive
from flatplank_hw.drive.params import DriveParameters
from flatplank_hw.drive.safety import REASONS

__all__ = ["REASONS", "AxisDrive", "DriveParameters"]
