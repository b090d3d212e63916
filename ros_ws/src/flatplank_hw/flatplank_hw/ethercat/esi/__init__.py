# SPDX-License-Identifier: Apache-2.0
"""Imports device descriptions (ESI, ETG.2000) and network configurations (ENI, ETG.2100) into the
bus file."""

from flatplank_hw.ethercat.esi.elements import EsiDevice
from flatplank_hw.ethercat.esi.merge import merge_device, slave_from_device
from flatplank_hw.ethercat.esi.numbers import EsiError
from flatplank_hw.ethercat.esi.read import find_device, read_esi

__all__ = ["EsiDevice", "EsiError", "find_device", "merge_device", "read_esi", "slave_from_device"]
