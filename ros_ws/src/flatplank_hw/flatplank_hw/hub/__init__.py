# SPDX-License-Identifier: Apache-2.0
"""Measurement hub: bridge volts to forces and moments."""

from flatplank_hw.hub.hub import MeasurementHub
from flatplank_hw.hub.params import HubParameters

__all__ = ["HubParameters", "MeasurementHub"]
