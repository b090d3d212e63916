# SPDX-License-Identifier: Apache-2.0
"""A node of its own process that turns the wheel until it is killed; arguments: bus file, launch
words."""

from __future__ import annotations

import sys

from ethercat_rig import InsistentNode

from flatplank_hw.ethercat.master import BusClient
from flatplank_sim.emulated import MASTER


def main() -> None:
    client = BusClient(sys.argv[1], MASTER, launch=sys.argv[2:])
    client.start()
    node = InsistentNode(client)
    node.cycles(10)
    node.spin_up()
    print("turning", flush=True)
    node.run(lambda _inputs: False, seconds=60.0)


if __name__ == "__main__":
    main()
