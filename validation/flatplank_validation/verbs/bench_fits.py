# SPDX-License-Identifier: Apache-2.0
"""The numbers that the fits must reach, beside their goals."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from flatplank_analysis.cli import common
from flatplank_data.arguments import Parser, add_json
from flatplank_validation.fits import (
    bag_import,
    campaign_fit,
    large_bag,
    magic_formula,
    nonlinear_fit,
    tires,
)

Part = Callable[[argparse.Namespace], Mapping[str, float]]
#: part -> measured quantity, limit
PARTS: Mapping[str, tuple[Part, str]] = {
    "magic_formula": (lambda _: magic_formula.measure(), "wanted: time_s at most 1"),
    "nonlinear_fit": (
        lambda _: nonlinear_fit.measure(),
        "wanted: ratio at least 100, relative_difference below 1e-4",
    ),
    "campaign_fit": (
        lambda o: campaign_fit.measure(o.runs),
        "wanted for 800 runs: total_s at most 240, memory below 2048",
    ),
    "tires": (
        lambda _: tires.measure(),
        "all four through simulate, fit and report; wanted: C_Fk within 3 %, c_cx and sigma_x "
        "without the model's bias within 7 %, r_e within 1 %",
    ),
    "large_bag": (
        lambda o: large_bag.measure(o.gigabytes),
        "one bag of another bench; wanted for 2 GB: time_s at most 300, memory_over_size below 2",
    ),
    "bag_import": (lambda o: bag_import.measure(o.bags), "wanted: ratio at least 0.5"),
}


def main(argv: Sequence[str] | None = None) -> int:
    """`flatplank bench-fits [PART...] [--runs N] [--gigabytes N] [--bags DIR] [--json]`."""
    parser = Parser(prog="flatplank bench-fits", description=__doc__)
    parser.add_argument("parts", nargs="*", help=f"some of {', '.join(PARTS)}; default: all")
    parser.add_argument("--runs", type=int, default=800, help="of campaign_fit (default 800)")
    parser.add_argument("--gigabytes", type=float, default=2.0, help="of large_bag (default 2)")
    parser.add_argument("--bags", type=Path, help="campaign of bags; without it no bag_import")
    add_json(parser)
    chosen = parser.parse_args(argv)
    unknown = [p for p in chosen.parts if p not in PARTS]
    if unknown:
        parser.error(f"unknown part '{unknown[0]}'; known are {', '.join(PARTS)}")
    if "bag_import" in chosen.parts and chosen.bags is None:
        parser.error("bag_import needs --bags DIR: flatplank simulate DIR --bags makes some")
    wanted = chosen.parts or [p for p in PARTS if p != "bag_import" or chosen.bags]
    return common.run_or_report_nothing_usable("bench-fits", lambda: _run(wanted, chosen))


def _run(wanted: Sequence[str], chosen: argparse.Namespace) -> int:
    found = {}
    for name in wanted:
        measure, goal = PARTS[name]
        found[name] = measure(chosen)
        if not chosen.json:
            print(f"{name} ({goal})")
            for key, value in found[name].items():
                print(f"  {key:22s} {value:.6g}", flush=True)
    if chosen.json:
        print(json.dumps({"format": "flatplank-bench-fits/1", **found}))
    return 0
