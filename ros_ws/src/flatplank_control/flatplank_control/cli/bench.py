# SPDX-License-Identifier: Apache-2.0
"""Start the bench: the nodes of the graph, simulated or real.

On the simulated plant, on the emulated bus, or in the lab.
"""

from __future__ import annotations

import argparse
import signal
import sys
import threading
import time
from pathlib import Path

from flatplank_control.bench.processes import BenchProcesses, StartProgress
from flatplank_control.bench.setup import EVERY_NODE, BenchSetup
from flatplank_control.road_map import with_road
from flatplank_data.arguments import Parser, add_namespace
from flatplank_hw.bus.pacing import PACES


def parser() -> argparse.ArgumentParser:
    p = Parser(prog="flatplank bench", description=__doc__)
    kind = p.add_mutually_exclusive_group(required=True)
    for name, text in {
        "sim": "simulated plant, no machine",
        "emulated": "EtherCAT frames against the emulated bus",
        "lab": "the machine, on --interface",
    }.items():
        option = "--emulated-bus" if name == "emulated" else f"--{name}"
        kind.add_argument(option, dest="kind", action="store_const", const=name, help=text)
    p.add_argument(
        "--tire", default="toyo", help="simulated tire: toyo, continental, michelin, racing"
    )
    p.add_argument("--preset", default="", help="defects of the simulated machine: thesis2023")
    p.add_argument(
        "--plant", dest="plant_file", metavar="FILE", default="",
        help="YAML file laid over the plant's own",
    )  # fmt: skip
    p.add_argument("--seed", type=int, default=1, help="of the simulated plant")
    p.add_argument("--rate", dest="rate_hz", type=int, default=250, help="bus rate [Hz]")
    p.add_argument("--batch", type=int, default=1, help="bus cycles per message")
    p.add_argument("--pace", default="realtime", choices=PACES)
    p.add_argument(
        "--separate", action="store_const", const=(EVERY_NODE,), default=(),
        help="every node in a process of its own",
    )  # fmt: skip
    add_namespace(p)
    p.add_argument("--axes", default="", help="driven beside the wheel: plank,vertical,...")
    p.add_argument("--road", default="", help="slip by the road's travel: follow, or a map's file")
    p.add_argument("--interface", default="", help="network interface of the bus, with --lab")
    p.add_argument(
        "--bus", dest="bus_file", metavar="FILE", default="",
        help="bus file of --lab or --emulated-bus; default: ours",
    )  # fmt: skip
    p.add_argument("--calibration", default="", help="book; default: of --data, else the one here")
    p.add_argument("--data", default="data", help="folder for the bags")
    return p


def setup_of(o: argparse.Namespace) -> BenchSetup:
    """Bench set-up from the options; ValueError when a given book does not exist."""
    values = vars(o)
    road = values.pop("road")
    return with_road(BenchSetup.from_arguments(values, "--{} {}"), road)


def main(argv: list[str]) -> int:
    """Run until Ctrl-C or until a node ends."""
    setup = setup_of(parser().parse_args(argv))
    over = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: over.set())
    with BenchProcesses(setup) as processes:
        names = ", ".join(processes.nodes())
        print(
            f"bench: {names}\nbags go to {Path(setup.data).resolve()}; Ctrl-C ends it", flush=True
        )
        why = watch(processes, over)
    if why:
        print(f"flatplank bench: {why}", file=sys.stderr)
    return int(bool(why))


def program() -> int:
    """The verb as a program of its own, for `ros2 run flatplank_control bench`."""
    try:
        return main(sys.argv[1:])
    except (ValueError, OSError) as error:
        print(f"bench: {' '.join(str(error).split())}", file=sys.stderr)
        return 2


def watch(processes: BenchProcesses, over: threading.Event) -> str:
    """Print how many nodes are up, then wait; returns why the bench has ended, empty at Ctrl-C."""
    start = StartProgress(processes.nodes(), time.monotonic())
    while not over.wait(0.2):
        if why := processes.why_ended():
            return why
        if start.missing:
            before, now, vitals = str(start), time.monotonic(), processes.vitals()
            for name in [name for name, seen in vitals.items() if seen.started]:
                start.register_answer(name, "", now)
            if str(start) != before:
                print(start, flush=True)
            if why := start.why_waiting_is_useless(vitals, now):
                return why
    return ""
