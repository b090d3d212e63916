# SPDX-License-Identifier: Apache-2.0
"""One measurement on a running bench: slip step or r_e."""

from __future__ import annotations

import argparse
import sys

from flatplank_control.cli.operator import OF_A_RUN, Keys, call_service_of_key
from flatplank_control.runner.measurement import from_mapping
from flatplank_data.arguments import Parser, add_json, add_namespace, for_programs
from flatplank_data.machine import USUAL_RADIUS


def parser() -> argparse.ArgumentParser:
    p = Parser(prog="flatplank slip", description=__doc__)
    p.add_argument("kappa", type=float, nargs="?", help="slip [%%], driving > 0")
    p.add_argument("--free-rolling", action="store_true", help="controller run, gives r_e")
    p.add_argument("--re", type=float, default=USUAL_RADIUS, help="effective rolling radius [m]")
    p.add_argument("--at", type=float, default=1.5, help="plank position of the step [m]")
    p.add_argument("--end", type=float, default=4.1, help="plank position of the end [m]")
    p.add_argument("--tire", default="TOY", help="name of the tire in the files")
    p.add_argument("--fz", type=float, default=3700.0, help="vertical force [N]")
    p.add_argument("--pressure", type=float, default=2.5, help="[bar]")
    p.add_argument("--alpha", type=float, default=0.0, help="side slip angle [deg]")
    p.add_argument("--gamma", type=float, default=0.0, help="camber [deg]")
    p.add_argument("--start", type=int, default=1, choices=(1, 2, 3), help="0, 120, 240 deg")
    p.add_argument("--lab", action="store_true", help="manual steps are asked for, not simulated")
    add_namespace(p)
    add_json(p)
    return p


def print_line(text: str) -> None:
    print(text, flush=True)


def main(argv: list[str]) -> int:
    """Exit code 0: the bag was recorded."""
    options = parser().parse_args(argv)
    if (options.kappa is None) != options.free_rolling:
        print("flatplank slip: give a slip in %, or --free-rolling", file=sys.stderr)
        return 2
    plan = {
        "measurement": "free_rolling" if options.free_rolling else "slip",
        "kappa": (options.kappa or 0.0) / 100.0,
        "effective_rolling_radius": options.re,
        "step_position": options.at,
        "end_position": options.end,
        "tire": options.tire,
        "fz": options.fz,
        "pressure": options.pressure,
        "alpha_deg": options.alpha,
        "gamma_deg": options.gamma,
        "start": options.start,
    }
    from_mapping(plan, "options")
    from flatplank_control.nodes.client import BenchClient, BenchError

    def look() -> None:
        call_service_of_key(client, OF_A_RUN, keys.pressed())

    try:
        with (
            for_programs(options.json) as found,
            BenchClient(namespace=options.namespace) as client,
            Keys() as keys,
        ):
            print("keys: " + ", ".join(f"{k} {wish.text}" for k, wish in OF_A_RUN.items()))
            bags = client.measure(plan, simulated=not options.lab, say=print_line, idle=look)
            print("\n".join(bags))
            found["bags"] = [*bags]
    except BenchError as error:
        print(f"flatplank slip: {error}", file=sys.stderr)
        return 1
    return 0
