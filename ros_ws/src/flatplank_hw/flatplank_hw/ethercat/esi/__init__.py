# SPDX-License-Identifier: Apache-2.0
"""Import of makers' device descriptions (ESI, ETG.2000) into the bus file."""

from flatplank_hw.ethercat.esi.merge import merge_device, slave_from_device
from flatplank_hw.ethercat.esi.read import EsiDevice, EsiError, find_device, read_esi

__all__ = [
    "EsiDevice",
    "EsiError",
    "find_device",
    "merge_device",
    "read_esi",
    "slave_from_device",
]
