# SPDX-License-Identifier: Apache-2.0
"""A fitted tire as an FMU (FMI 3.0), for vehicle simulation.

Co-simulation: load, velocities and angles of the wheel -> forces that follow with a lag.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

from flatplank_analysis.cli import common
from flatplank_analysis.fmu.build import write_fmu
from flatplank_analysis.fmu.tire import LAWS
from flatplank_data.arguments import Parser, add_json
from flatplank_tire.tir import read_tir


def main(argv: Sequence[str] | None = None) -> int:
    """`flatplank fmu TIRE.tir OUT.fmu [--model mf_contact_point|mf] [--json]`."""
    parser = Parser(prog="flatplank fmu", description=__doc__)
    parser.add_argument("file", metavar="TIRE.tir", help="of a fit or a report")
    parser.add_argument("out", metavar="OUT.fmu", help="the FMU to write")
    titles = "; ".join(f"{name}: {law.title}" for name, law in LAWS.items())
    parser.add_argument(
        "--model", choices=LAWS, default=next(iter(LAWS)), help=f"{titles} (default: the first)"
    )
    add_json(parser)
    arguments = parser.parse_args(argv)
    tire = read_tir(arguments.file)
    for warning in tire.warnings():
        print(f"warning: {warning}", file=sys.stderr)
    written = write_fmu(tire, arguments.model, arguments.out)
    if written.lack:
        print(
            f"warning: {arguments.out} has sources and no binary: {written.lack}", file=sys.stderr
        )
    if arguments.json:
        common.print_json(
            {
                "file": arguments.out, "model": arguments.model, "binary": written.binary,
                "files": list(written.files),
            }
        )  # fmt: skip
    else:
        binary = f"binary for {written.binary}" if written.binary else "sources"
        print(f"{arguments.out}: {LAWS[arguments.model].title}; {binary}")
    return 0
