# SPDX-License-Identifier: Apache-2.0
"""The bus process; `BusClient` starts it and holds the other ends of its sockets."""

from __future__ import annotations

import argparse
import gc
import os
import signal
from dataclasses import replace

from flatplank_hw.ethercat.master.interface import (
    BusError,
    InterfaceLock,
    check_interface,
    check_permission,
)
from flatplank_hw.ethercat.master.link import ParentLink
from flatplank_hw.ethercat.master.loop import BusLoop, Timing
from flatplank_hw.ethercat.reader import read_bus_file
from flatplank_hw.process import prepare_thread


def parse(arguments: list[str] | None) -> argparse.Namespace:
    """Command line."""
    parser = argparse.ArgumentParser(prog="ethercat_master")
    parser.add_argument("--interface", required=True)
    parser.add_argument("--bus", required=True)
    parser.add_argument("--rate", type=int, default=0)
    parser.add_argument("--data-fd", type=int, required=True)
    parser.add_argument("--control-fd", type=int, required=True)
    parser.add_argument("--fifo", action="store_true")
    parser.add_argument("--slip", action="store_true")
    parser.add_argument("--reply-timeout-ms", type=float, default=0.0)
    parser.add_argument("--node-timeout-ms", type=float, default=0.0)
    parser.add_argument("--batch", type=int, default=1)
    return parser.parse_args(arguments)


def make_loop(options: argparse.Namespace, link: ParentLink, lock: InterfaceLock) -> BusLoop:
    """Bring the bus to OP; BusError or BusFileError on failure."""
    bus = read_bus_file(options.bus)
    if options.rate:
        bus = replace(bus, rate_hz=options.rate)
    check_interface(options.interface)
    check_permission()
    lock.acquire()
    try:
        from flatplank_hw.ethercat.master.soem import SoemBus
    except ImportError as error:
        raise BusError(f"{error}; install it: pip install pysoem") from None
    soem = SoemBus(bus, options.interface)
    soem.open()
    reply_timeout, node_timeout = options.reply_timeout_ms * 1e-3, options.node_timeout_ms * 1e-3
    timing = Timing(options.slip, reply_timeout, node_timeout, options.batch)
    loop = BusLoop(bus, soem, link, prepare_thread(options.fifo, priority=50), timing)
    try:
        loop.start()
    except ValueError:
        soem.close()
        raise
    return loop


def main(arguments: list[str] | None = None) -> int:
    """Report 'ready' or 'failed' to the parent, cycle until told to end, stop."""
    options = parse(arguments)
    link = ParentLink(options.data_fd, options.control_fd)
    lock = InterfaceLock(options.interface)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        loop = make_loop(options, link, lock)
    except ValueError as error:
        link.send_message({"event": "failed", "reason": str(error)})
        return 2
    signal.signal(signal.SIGTERM, lambda *_: setattr(loop, "running", False))
    gc.collect()
    gc.freeze()
    gc.disable()
    link.send_message({"event": "ready", "pid": os.getpid(), "scheduling": loop.scheduling})
    try:
        loop.run()
    except Exception as error:
        # the watchdogs stop the axes; report the reason to the parent
        link.send_message({"event": "crashed", "reason": f"{type(error).__name__}: {error}"})
        raise
    finally:
        loop.soem.close()
        lock.release()
    link.send_message({"event": "stopped", "diagnostics": loop.report()})
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
