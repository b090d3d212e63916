# SPDX-License-Identifier: Apache-2.0
"""Forces, radius and stiffness of a `.tir` at one point."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence

from flatplank_analysis.cli import common
from flatplank_analysis.models.base import SPEED
from flatplank_analysis.models.tire_state import tire_state
from flatplank_data.arguments import Parser, add_json
from flatplank_data.errors import FlatplankError
from flatplank_tire.magic_formula import SWITCHES
from flatplank_tire.tir import read_tir

UNITS = {
    "fx": "N",
    "fy": "N",
    "mz": "Nm",
    "mx": "Nm",
    "my": "Nm",
    "re": "m",
    "a": "m",
    "sigma_x": "m",
    "sigma_y": "m",
    "kx": "N",
    "ky": "N/rad",
}


def main(argv: Sequence[str] | None = None) -> int:
    """`flatplank tire FILE.tir --fz N ... [--json]`; ISO W, SI."""
    parser = Parser(prog="flatplank tire", description=__doc__)
    parser.add_argument("file", metavar="FILE.tir")
    parser.add_argument("--fz", type=float, required=True, help="vertical force [N]")
    parser.add_argument("--kappa", type=float, default=0.0, help="slip, driving > 0 [-]")
    parser.add_argument("--alpha", type=float, default=0.0, help="side slip angle [rad]")
    parser.add_argument("--gamma", type=float, default=0.0, help="camber angle [rad]")
    parser.add_argument(
        "--pressure", type=float, help="[Pa] (default: that of the file, else nominal)"
    )
    turn = "curvature of the path [1/m], left > 0 (default: without turn slip)"
    parser.add_argument("--turn-slip", type=float, metavar="CURVATURE", help=turn)
    parser.add_argument("--vx", type=float, default=SPEED, help="speed [m/s]")
    for name, text in SWITCHES.items():
        option = f"--{name.lower().replace('_', '-')}"
        parser.add_argument(option, dest=name, type=float, metavar="NUMBER", help=text)
    add_json(parser)
    arguments = parser.parse_args(argv)
    for name in ("alpha", "gamma"):
        _check_angle(name, getattr(arguments, name))
    tire = read_tir(arguments.file)
    set_here = {k: getattr(arguments, k) for k in SWITCHES if getattr(arguments, k) is not None}
    tire = tire.replaced(set_here)
    for warning in tire.warnings(arguments.vx):
        print(f"warning: {warning}", file=sys.stderr)
    names = ("fz", "kappa", "alpha", "gamma", "pressure", "vx", "turn_slip")
    state = tire_state(tire, **{name: getattr(arguments, name) for name in names}).to_json()
    if arguments.json:
        common.print_json(state)
    else:
        rows = [(k, "-" if v is None else f"{v:.6g}", UNITS[k]) for k, v in state.items()]
        common.print_rows(("", "value", "unit"), rows)
    return 0


def _check_angle(name: str, value: float) -> None:
    """Refuse an angle so large that it must be in degrees."""
    if not abs(value) < 0.5 * math.pi:
        raise FlatplankError(
            f"{value:g} rad is {math.degrees(value):.0f} deg, beyond 90",
            f"--{name}",
            f"angles are in rad here: {math.radians(value):.4g} for {value:g} deg",
        )
