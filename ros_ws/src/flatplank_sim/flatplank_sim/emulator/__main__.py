# SPDX-License-Identifier: Apache-2.0
"""`python -m flatplank_sim.emulator --interface veth1 --bus bench.yaml [--control PATH]`"""

from __future__ import annotations

import argparse
import signal
import sys
from dataclasses import replace

from flatplank_hw.ethercat.reader import read_bus_file
from flatplank_sim.emulator.bench import EmulatedBench, make_plant
from flatplank_sim.emulator.control import ControlServer
from flatplank_sim.emulator.faults import FaultTargets
from flatplank_sim.emulator.requests import RequestHandler
from flatplank_sim.emulator.runner import Port, Runner
from flatplank_sim.emulator.wire import Wire

WARM_UP = 5
"""cycles before the first frame, in which the plant compiles and loads its kernels"""


def parse(arguments: list[str] | None) -> argparse.Namespace:
    """Command line."""
    parser = argparse.ArgumentParser(
        prog="ethercat_emulator", description="EtherCAT slaves in software"
    )
    parser.add_argument("--interface", required=True, help="one end of a veth pair")
    parser.add_argument("--bus", required=True, help="bus file (YAML)")
    parser.add_argument("--control", default="", help="path of the control socket")
    parser.add_argument(
        "--rate", type=int, default=0, help="cycles per second; 0: as in the bus file"
    )
    parser.add_argument("--plant", default="simulated", help="'simulated' or module:function")
    parser.add_argument(
        "--option", action="append", default=[], metavar="KEY=VALUE", help="of the plant"
    )
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--max-age-ms", type=float, default=5.0, help="older frames are dropped")
    parser.add_argument(
        "--master-timeout-ms", type=float, default=0.0, help="a master may be silent for so long"
    )
    parser.add_argument("--fifo", action="store_true", help="SCHED_FIFO when allowed")
    parser.add_argument(
        "--with-parent", action="store_true", help="end when the standard input is closed"
    )
    return parser.parse_args(arguments)


def make_runner(options: argparse.Namespace) -> Runner:
    """Make and connect bench, wire, port and control socket."""
    bus = read_bus_file(options.bus)
    if options.rate:
        bus = replace(bus, rate_hz=options.rate)
    pairs = dict(text.partition("=")[::2] for text in options.option)
    axes = [s.axis for s in bus.slaves if s.axis]
    plant = make_plant(options.plant, bus.rate_hz, options.seed, pairs, axes)
    bench = EmulatedBench(bus, plant)
    port = Port(options.interface)
    wire = Wire(max_age_ns=round(options.max_age_ms * 1e6), seed=options.seed)
    runner = Runner(bench, wire, port, master_timeout_ns=round(options.master_timeout_ms * 1e6))
    if options.control:
        handler = RequestHandler(
            FaultTargets(bench, wire, port.set_link),
            stop=lambda: setattr(runner, "running", False),
            facts=runner.facts,
        )
        runner.attach(ControlServer(options.control, handler))
    return runner


def main(arguments: list[str] | None = None) -> int:
    """Run until told to stop; print one line and return exit code 2 when it cannot start."""
    options = parse(arguments)
    try:
        runner = make_runner(options)
    except ValueError as error:
        print(f"ethercat_emulator: {error}", file=sys.stderr)
        return 2
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: setattr(runner, "running", False))
    for _ in range(WARM_UP):
        runner.bench.step()
    if options.with_parent:
        runner.end_with(sys.stdin.fileno())
    print("ready", flush=True)
    runner.run(fifo=options.fifo)
    runner.close()
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
