# SPDX-License-Identifier: Apache-2.0
"""Sweeps of other benches: where a `.tir` fails; a new one.

Text, TYDEX and .mat files, cut into conditions with B, C, D, E.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from flatplank_analysis.cli import common
from flatplank_analysis.cli.fit import print_coefficients
from flatplank_analysis.slip_sweeps.axes import SYSTEMS
from flatplank_analysis.slip_sweeps.conditions import FORCE, HELD, SweepCondition
from flatplank_analysis.slip_sweeps.curves import Curve, Failure
from flatplank_analysis.slip_sweeps.fit import SweepFit, fit_sweeps
from flatplank_analysis.slip_sweeps.formula import NAMES, Formula
from flatplank_analysis.slip_sweeps.moment import MOMENT
from flatplank_analysis.slip_sweeps.raw import RAW
from flatplank_analysis.slip_sweeps.study import Study, by_level, lacking, study
from flatplank_analysis.slip_sweeps.tir_signs import CONVENTIONS, READ, likelier, side_of
from flatplank_analysis.slip_sweeps.verdict import RISK, fails
from flatplank_data.arguments import Parser, add_json
from flatplank_data.errors import FlatplankError
from flatplank_tire.tir import VERSIONS, TirFile, read_tir


def main(argv: Sequence[str] | None = None) -> int:
    """`flatplank sweeps FILE... [--tir FILE | --fit OUT.tir] [--axes NAME] [--turn CHANNEL]`."""
    parser = Parser(prog="flatplank sweeps", description=__doc__)
    parser.add_argument("file", metavar="FILE", nargs="+", help=f"{', '.join(RAW)} with sweeps")
    parser.add_argument("--tir", metavar="FILE", help="tire property file to compare with")
    parser.add_argument("--tir-signs", choices=CONVENTIONS, default=READ,
                        help="signs under which the tire file was fitted")  # fmt: skip
    parser.add_argument("--fit", metavar="OUT.tir", help="fit a tire file to all sweeps")
    parser.add_argument("--mf", choices=VERSIONS, help="version of the fitted equations; "
                        "default: that of --start, or 6.1")  # fmt: skip
    parser.add_argument("--start", metavar="FILE.tir", help="values of what is not determined")
    parser.add_argument("--radius", type=float, help="of the free tire, for the fitted file [m]")
    parser.add_argument("--axes", choices=SYSTEMS, help="of the file; default: by its signs")
    parser.add_argument("--turn", metavar="CHANNEL", nargs="+", default=(),
                        help="channels that the file counts the other way, as alpha")  # fmt: skip
    parser.add_argument("--columns", metavar="CHANNEL=COLUMN", nargs="+", default=(),
                        help="columns with other names, as fy='Side load'")  # fmt: skip
    parser.add_argument("--figure", metavar="FILE", help="picture of the curves (.png)")
    add_json(parser)
    o = parser.parse_args(argv)
    _check(o)
    studies = [study(file, o.axes, o.turn, _names(o.columns)) for file in o.file]
    tir, fitted = read_tir(o.tir) if o.tir else None, None
    if o.fit:
        fitted = fit_sweeps(
            studies, read_tir(o.start) if o.start else None, o.radius, common.show_progress, o.mf
        )
        fitted.save(o.fit)
        tir = read_tir(o.fit)
    if o.figure:
        from flatplank_analysis.discovery.report.figures import png

        for found, path in zip(studies, _figures(o.figure, len(studies)), strict=True):
            path.write_bytes(png(found.plot(tir, o.tir_signs)))
    if o.json:
        told = [found.to_json(tir, o.tir_signs) for found in studies]
        rest = {"fit": {"file": o.fit, **fitted.to_json()}} if fitted else {}
        common.print_json((told[0] if len(told) == 1 else {"sweeps": told}) | rest)
        return 0
    for found in studies:
        _tell(found)
        if tir:
            _tell_failures(found, tir, o.fit or o.tir, o.tir_signs)
    if fitted:
        _tell_fit(fitted, o.fit)
    for line in lacking([c for found in studies for c in found.conditions]):
        print(line)
    return 0


def _check(o: argparse.Namespace) -> None:
    if o.tir and o.fit:
        what, remedy = "compares with one file", "leave --tir out, or compare first"
        raise FlatplankError(what, "--fit and --tir", remedy)
    if o.tir_signs != READ and not o.tir:
        raise FlatplankError("belongs to a tire file", "--tir-signs", "give --tir FILE")
    if not o.fit and (o.start or o.radius or o.mf):
        where = "--start, --radius and --mf"
        raise FlatplankError("belong to a fit", where, "give --fit OUT.tir")
    if o.radius is not None and not 0.0 < o.radius < 2.0:
        raise FlatplankError(f"{o.radius:g} m", "--radius", "give the free radius in m, as 0.26")


def _figures(first: str, count: int) -> list[Path]:
    """One path per sweep file: curves.png, curves_2.png, ..."""
    path = Path(first)
    return [path, *(path.with_stem(f"{path.stem}_{k}") for k in range(2, count + 1))]


def _tell_fit(fitted: SweepFit, path: str) -> None:
    print(f"\n{path}: Magic Formula {fitted.file.law}, fitted to {fitted.points} bins")
    print_coefficients(fitted.fit)
    if fitted.held_out:
        print("\neach load predicted by a fit to the others:")
        rows = [
            (h.force.capitalize(), f"{h.load:.0f}", *_in_unit(h.error, h.force),
             f"{h.r_squared:.4f}")
            for h in fitted.held_out
        ]  # fmt: skip
        common.print_rows(("force", "load [N]", "error", "unit", "R2"), rows)
    for name, why in fitted.remarks.items():
        print(f"note: {name} {why}")


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
    units = list(dict.fromkeys(c.slip.unit for c in found.conditions))
    per = units[0] if len(units) == 1 else f"({' or '.join(units)})"
    header = ("condition", "swept", *(f"{h.title} [{h.unit}]" for h in held), "samples",
              "floor [N]", f"B [1/{per}]", "C", "D [N]", "E", f"BCD [N/{per}]",
              "rms [N]")  # fmt: skip
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
    print("in brackets: not known to a half")


def _cells(formula: Formula | None, per: float) -> tuple[str, ...]:
    """B, C, D, E, BCD, rms; B and BCD are multiplied by `per`."""
    if formula is None:
        return ("-",) * 6
    scale = {"B": per, "C": 1.0, "D": 1.0, "E": 1.0}
    numbers = {n: f"{scale[n] * formula.values[n]:.4g}" for n in NAMES[:4]}
    cells = (text if formula.known(n) else f"({text})" for n, text in numbers.items())
    return (*cells, f"{per * formula.stiffness:.4g}", f"{formula.rms:.1f}")


def _chance(value: float) -> str:
    """A chance with one digit; below 0.0001 its limit."""
    return f"{value:.1g}" if value >= 1e-4 else "<0.0001"


def _tell_failures(found: Study, tir: TirFile, name: str, signs: str) -> None:
    failures, moments = found.failures(tir, signs), found.moment_failures(tir, signs)
    rows = [
        (k, FORCE[c.swept], c, curve, failure)
        for k, (c, curve, failure) in enumerate(
            zip(found.conditions, found.curves, failures, strict=True), start=1
        )
    ]
    turned = [
        (k + 1, MOMENT, found.conditions[k], found.moments[k], failure)
        for k, failure in moments.items()
    ]
    read = "" if signs == READ else f", with the signs of {CONVENTIONS[signs].title}"
    print(f"\nwhere {name} fails{read}, worst first:")
    _print_worst(rows, "error [N]", "of the largest force [%]")
    for line in by_level(found.conditions, failures):
        print(line)
    _tell_signs(found, tir, signs)
    if turned:
        print("\nMz, worst first:")
        _print_worst(turned, "error [Nm]", "of the largest moment [%]")
    risk = f"an exact file would fail in any of them with a chance of {100.0 * RISK:g} %"
    print("chance: that scatter alone makes an error as large")
    for channel, each in (("", failures), (" in Mz", list(moments.values()))):
        known = [f.chance for f in each if np.isfinite(f.chance)]
        if each:
            count = f"{fails(known).sum()} of {len(known)} conditions with a floor"
            print(f"fails{channel} in {count} ({risk})")


Row = tuple[int, str, SweepCondition, Curve, Failure]
"""number of a condition, channel, condition, curve, error"""


def _print_worst(found: Sequence[Row], error: str, share: str) -> None:
    """The errors of a tire file, worst first."""
    rows = []
    for k, channel, c, curve, f in sorted(found, key=lambda row: -row[-1].share):
        ratio = f"{f.error / curve.floor:.1f}" if curve.floor > 0.0 else "-"
        at = f"{c.slip.scale * f.worst_slip:+.1f} {c.slip.unit}"
        worst, unit = _in_unit(f.worst, channel, "+")
        chance = _chance(f.chance) if np.isfinite(f.chance) else "-"
        size, part = _in_unit(f.error, channel)[0], f"{100.0 * f.share:.0f}"
        most = f"{channel.capitalize()} {worst} {unit} at {at}"
        rows.append((str(k), size, part, ratio, chance, most, c.label))
    header = ("condition", error, share, "floors", "chance", "off most", "where")
    common.print_rows(header, rows)


def _in_unit(value: float, channel: str, sign: str = "") -> tuple[str, str]:
    """A force [N] or moment [Nm] as text, and its unit."""
    moment = channel == MOMENT
    return f"{value:{sign}.{int(moment)}f}", "Nm" if moment else "N"


def _tell_signs(found: Study, tir: TirFile, signs: str) -> None:
    """The conventions of signs under which the side force fits much better."""
    errors = found.errors_by_signs(tir)
    better = likelier(errors, signs) if errors else []
    if better:
        side = side_of(tir)
        stated = f"; the file says TYRESIDE {side}" if side else ""
        words = " or ".join(f"{CONVENTIONS[n].title} (--tir-signs {n})" for n in better)
        print(
            f"the side force is off by {errors[signs]:.0f} N under these signs, by "
            f"{errors[better[0]]:.0f} N under those of {words}{stated}: the file may have been "
            "fitted so"
        )
