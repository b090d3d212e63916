# SPDX-License-Identifier: Apache-2.0
"""The EtherCAT master: a process that owns pysoem, and `BusClient`, which talks to it."""

from flatplank_hw.ethercat.master.client import BusClient
from flatplank_hw.ethercat.master.interface import BusError

__all__ = ["BusClient", "BusError"]
