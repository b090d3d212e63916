# SPDX-License-Identifier: Apache-2.0
"""The EtherCAT master: the bus process, which uses pysoem, and its client `BusClient`."""

from flatplank_hw.ethercat.master.client import BusClient
from flatplank_hw.ethercat.master.interface import BusError

__all__ = ["BusClient", "BusError"]
