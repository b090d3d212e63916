# SPDX-License-Identifier: Apache-2.0
"""Waits for a line, then tries to start a second master; prints why it cannot.

Arguments: bus file, launch words."""

from __future__ import annotations

import sys

from flatplank_hw.ethercat.master import BusClient, BusError
from flatplank_sim.emulated import MASTER


def main() -> None:
    client = BusClient(sys.argv[1], MASTER, launch=sys.argv[2:])
    print("waiting", flush=True)
    sys.stdin.readline()
    try:
        client.start()
    except BusError as error:
        print(error, flush=True)
    else:
        client.stop()
        print("started", flush=True)


if __name__ == "__main__":
    main()
