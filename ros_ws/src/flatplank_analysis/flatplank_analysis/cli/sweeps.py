# SPDX-License-Identifier: Apache-2.0
"""Sweeps of other benches: conditions, where a `.tir` fails.

Text, TYDEX and .mat files, cut into conditions with B, C, D, E.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from flatplank_analysis.cli import common
from flatplank_analysis.models.tir import TirFile, read_tir
from flatplank_analysis.slip_sweeps.axes import SYSTEMS
from flatplank_analysis.slip_sweeps.conditions import FORCE, HELD
from flatplank_analysis.slip_sweeps.curves import NAMES, Formula
from flatplank_analysis.slip_sweeps.raw import RAW
from flatplank_analysis.slip_sweeps.study import Study, by_level, study
from flatplank_analysis.slip_sweeps.verdict import RISK, fails
from flatplank_data.arguments import Parser, add_json
from flatplank_data.errors import FlatplankError


def main(argv: Sequence[str] | None = None) -> int:
    """`flatplank sweeps FILE [--tir FILE] [--axes NAME] [--turn CHANNEL] [--columns ...]`."""
    parser = Parser(prog="flatplank sweeps", description=__doc__)
    parser.add_argument("file", metavar="FILE", help=f"{', '.join(RAW)} with sweeps")
    parser.add_argument("--tir", metavar="FILE", help="tire property file to compare with")
    parser.add_argument("--axes", choices=SYSTEMS, help="of the file; default: by its signs")
    parser.add_argument("--turn", metavar="CHANNEL", nargs="+", default=(),
                        help="channels that the file counts the other way, as alpha")  # fmt: skip
    parser.add_argument("--columns", metavar="CHANNEL=COLUMN", nargs="+", default=(),
                        help="columns with other names, as fy='Side load'")  # fmt: skip
    parser.add_argument("--figure", metavar="FILE", help="picture of the curves (.png)")
    add_json(parser)
    o = parser.parse_args(argv)
    found = study(o.file, o.axes, o.turn, _names(o.columns))
    tir = read_tir(o.tir) if o.tir else None
    if o.figure:
        from flatplank_analysis.discovery.report.figures import png

        Path(o.figure).write_bytes(png(found.plot(tir)))
    if o.json:
        common.print_json(found.to_json(tir))
        return 0
    _tell(found)
    if tir:
        _tell_failures(found, tir, o.tir)
    for line in found.lacking():
        print(line)
    return 0


def _names(given: Sequence[str]) -> dict[str, str]:
    """Channel -> column of arguments CHANNEL=COLUMN."""
    wrong = next((text for text in given if "=" not in text), None)
    if wrong is not None:
        raise FlatplankError(f"'{wrong}' is not CHANNEL=COLUMN", "--columns", "write fy=Fy_left")
    return dict(text.split("=", 1) for text in given)


def _tell(found: Study) -> None:
    print(f"{found.path}: {len(found.columns['fz'])} samples, {len(found.conditions)} conditions")
    for line in found.said:
        print(line)
    if found.further:
        print(f"further columns, kept: {', '.join(found.further)}")
    stated = found.conditions[0].stated
    held = [h for h in HELD if h.name in stated]
    same = found.conditions[0].held
    alike = [
        f"{h.title} {h.word(same[h.name])}"
        for h in HELD
        if h.name in same and h.name not in stated
    ]
    print(f"the same in all conditions: {', '.join(alike)}\n" if alike else "")
    header = ("", "swept", *(f"{h.title} [{h.unit}]" for h in held), "samples",
              "floor [N]", *NAMES[:4], "BCD", "rms [N]")  # fmt: skip
    rows = []
    for k, (c, curve, formula) in enumerate(
        zip(found.conditions, found.curves, found.formulas, strict=True), start=1
    ):
        levels = (h.word(c.held[h.name]).split()[0] if h.name in c.held else "-" for h in held)
        floor = f"{curve.floor:.1f}" if np.isfinite(curve.floor) else "-"
        cells = (str(k), c.slip.title, *levels, str(len(c.samples)), floor)
        rows.append((*cells, *_cells(formula, 1.0 / c.slip.scale)))
    common.print_rows(header, rows)
    sources = sorted({curve.floor_from for curve in found.curves})
    print(f"\nfloor: from {'; or '.join(sources)}")
    print("B and BCD per deg of slip angle or % of slip; in brackets: not known to a half")


def _cells(formula: Formula | None, per: float) -> tuple[str, ...]:
    """B, C, D, E, BCD, rms; B and BCD are multiplied by `per`."""
    if formula is None:
        return ("-",) * 6
    scale = {"B": per, "C": 1.0, "D": 1.0, "E": 1.0}
    numbers = {n: f"{scale[n] * formula.values[n]:.4g}" for n in NAMES[:4]}
    cells = (text if formula.known(n) else f"({text})" for n, text in numbers.items())
    return (*cells, f"{per * formula.stiffness:.4g}", f"{formula.rms:.1f}")


def _tell_failures(found: Study, tir: TirFile, name: str) -> None:
    failures = found.failures(tir)
    print(f"\nwhere {name} fails, worst first:")
    order = sorted(range(len(failures)), key=lambda k: -failures[k].share)
    rows = []
    for k in order:
        f, c, curve = failures[k], found.conditions[k], found.curves[k]
        ratio = f"{f.error / curve.floor:.1f}" if curve.floor > 0.0 else "-"
        at = f"{c.slip.scale * f.worst_slip:+.1f} {c.slip.unit}"
        force = FORCE[c.swept].capitalize()
        chance = f"{f.chance:.1g}" if np.isfinite(f.chance) else "-"
        rows.append((str(k + 1), f"{f.error:.0f}", f"{100.0 * f.share:.0f}", ratio, chance,
                     f"{force} {f.worst:+.0f} N at {at}", c.label))  # fmt: skip
    header = ("", "error [N]", "of the largest force [%]", "floors", "chance", "off most", "")
    common.print_rows(header, rows)
    for line in by_level(found.conditions, failures):
        print(line)
    known = [f.chance for f in failures if np.isfinite(f.chance)]
    risk = f"an exact file would fail in any of them with a chance of {100.0 * RISK:g} %"
    print("chance: that scatter alone makes an error as large")
    print(f"fails in {fails(known).sum()} of {len(known)} conditions with a floor ({risk})")
