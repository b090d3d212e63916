# SPDX-License-Identifier: Apache-2.0
"""Encoders: counts to positions, velocities and the state of motion."""

from flatplank_hw.encoders.encoders import Encoders
from flatplank_hw.encoders.params import EncoderParameters

__all__ = ["EncoderParameters", "Encoders"]
