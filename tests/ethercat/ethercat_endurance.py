# SPDX-License-Identifier: Apache-2.0
"""A bus that runs for a while beside other work; prints the account of all cycles as JSON.

Arguments: seconds, rate [Hz], busy processes beside it.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time

from ethercat_rig import BENCH, Emulator, InsistentNode, be_quick

from flatplank_hw.ethercat.master import BusClient
from flatplank_sim.emulated import MASTER, BenchNamespace

REPLY_TIMEOUT_MS = 12
BURN = "while True: pass"


def account(client: BusClient, emulator: Emulator, node: InsistentNode, images: int) -> dict:
    """Everything that a test or a reader wants to know."""
    report, state = client.diagnostics(), emulator.send("state")
    return {
        "report": report,
        "images": images,
        "gaps": node.gaps,
        "invented": client.invented,
        "trips": sum(s["watchdog_trips"] for s in state["slaves"]),
        "states": sorted({s["state"] for s in state["slaves"]}),
        "wire": state["wire"],
        "stalled_ms": state["stalled_ms"],
        "last_cycle": node.last.cycle,
    }


def main(seconds: float, rate: int, busy: int) -> None:
    burners = [subprocess.Popen([sys.executable, "-c", BURN]) for _ in range(busy)]
    try:
        with BenchNamespace() as ns:
            emulator = Emulator(
                ns, BENCH, "--rate", str(rate), "--max-age-ms", str(REPLY_TIMEOUT_MS)
            )
            client = BusClient(
                BENCH,
                MASTER,
                rate_hz=rate,
                slip=True,
                reply_timeout_ms=REPLY_TIMEOUT_MS,
                launch=ns.enter,
            )
            client.start()
            be_quick(True)
            node = InsistentNode(client)
            emulator.send("operator", name="unload")
            node.cycles(5)
            node.spin_up()
            first, images, end = node.last.cycle, 0, time.monotonic() + seconds
            while time.monotonic() < end:
                node.cycles(rate)
            images = node.last.cycle - first
            print(json.dumps(account(client, emulator, node, images)))
            client.stop()
            emulator.close()
    finally:
        for burner in burners:
            burner.kill()
            burner.wait()


if __name__ == "__main__":
    main(float(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
