# SPDX-License-Identifier: Apache-2.0
"""Calibrate an instrument, or show what is calibrated.

Instruments: hub, lvdt, plank, motor, friction, parasitic; `status` and `sheet` show what is
there.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import asdict
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np

from flatplank_control.bench.setup import BenchSetup
from flatplank_control.bench.simulator import simulator
from flatplank_control.calibration.book import (
    FILE,
    FIT,
    FRICTION,
    HUB,
    INSTRUMENTS,
    CalibrationBook,
    Entry,
)
from flatplank_control.calibration.fits import Line, fit_line
from flatplank_control.calibration.sheet import empty_sheet, starting_values
from flatplank_data.arguments import Parser, add_json, for_programs
from flatplank_data.params import from_mapping
from flatplank_data.yaml_text import dump_yaml
from flatplank_hw.hub.params import HubParameters

Result = dict[str, Any]
"""what a program is told"""
Work = Callable[[argparse.Namespace, CalibrationBook], Result]
HUB_AXES = ("fx", "fy", "fz")


def pairs_of(text: str) -> list[tuple[float, float]]:
    """Parse pairs such as `0:0.1,1000:996`."""
    try:
        return [(float(a), float(b)) for a, b in (item.split(":") for item in text.split(","))]
    except ValueError:
        raise ValueError(f"--pairs '{text}': write known:read, with commas") from None


def in_force(book: CalibrationBook, node: str) -> dict[str, Any]:
    """Calibrated parameters of a node on a bench that is started with this book."""
    return BenchSetup(kind="lab", calibration=str(book.path)).constants()[node]


def scaled(
    o: argparse.Namespace, book: CalibrationBook, instrument: str, line: Line, unit: str
) -> Entry:
    """Constants of an instrument in this book, scaled by the slope of a line."""
    have = in_force(book, INSTRUMENTS[instrument].nodes[0])
    old = {name: have[name] for name in INSTRUMENTS[instrument].parameters}
    values = {name: value * line.slope for name, value in old.items()}
    errors = {name: value * line.slope_error for name, value in old.items()}
    return Entry(instrument, o.date, values, line.residual, errors, unit)


def hub(o: argparse.Namespace, book: CalibrationBook) -> Result:
    """Calibrate the bridge constants of one axis by known loads."""
    line = fit_line(pairs_of(o.pairs), o.reading)
    if not 0.5 < line.slope < 2.0:
        raise ValueError(f"hub: {o.axis} reads {line.slope:.3g} times the load; check the wiring")
    return write_entry(book, scaled(o, book, f"hub_{o.axis}", line, "N"))


def lvdt(o: argparse.Namespace, book: CalibrationBook) -> Result:
    """Calibrate gain and offset of the LVDT by axle heights measured with a ruler."""
    line = fit_line([(volts, height) for height, volts in pairs_of(o.pairs)], o.reading)
    values = {"lvdt_gain": line.slope, "lvdt_offset": line.offset}
    errors = {"lvdt_gain": line.slope_error, "lvdt_offset": line.offset_error}
    return write_entry(book, Entry("lvdt", o.date, values, line.residual, errors, "m"))


def plank(o: argparse.Namespace, book: CalibrationBook) -> Result:
    """Calibrate the pitch radius of the pinion by measured travel against encoder travel."""
    line = fit_line([(read, known) for known, read in pairs_of(o.pairs)], o.reading)
    return write_entry(book, scaled(o, book, "plank_encoder", line, "m"))


def motor(o: argparse.Namespace, book: CalibrationBook) -> Result:
    """Calibrate the gear ratio by wheel angle against motor angle."""
    line = fit_line(pairs_of(o.pairs), o.reading)
    return write_entry(book, scaled(o, book, "motor", line, "rad"))


def friction(o: argparse.Namespace, book: CalibrationBook) -> Result:
    """Measure the friction torque of the wheel drive by turns of the unloaded wheel."""

    from flatplank_control.calibration.friction import friction_of, turns_of

    if bool(o.bag) == o.sim:
        raise ValueError("friction: give --bag of unloaded turns at several speeds, or --sim")
    setup = BenchSetup(preset=o.preset, tire=o.tire, pace="hold")
    tables = [simulator().speeds_on_twin(setup)] if o.sim else [turns_of(path) for path in o.bag]
    found = friction_of(tables)
    for speed, torque, scatter in zip(found.speed, found.torque, found.scatter, strict=True):
        print(f"{speed:7.1f} rad/s  {torque:.3f} N m +- {scatter:.3f}")
    rows = ([round(float(v), 4) for v in row] for row in (found.speed, found.torque))
    values = dict(zip(FRICTION, rows, strict=True))
    scatter = float(np.sqrt(np.mean(found.scatter**2)))
    return write_entry(book, Entry("friction", o.date, values, scatter, unit="N m"))


def parasitic(o: argparse.Namespace, book: CalibrationBook) -> Result:
    """Identify the parasitic fit of this mounting by three turns of the unloaded wheel."""

    from flatplank_control.calibration.parasitic import identify_turn, turn_of_bag

    if (o.bag is None) != o.sim:
        raise ValueError("parasitic: give --bag of an unloaded turn, or --sim")
    turn = (
        simulator().turn_on_twin(BenchSetup(preset=o.preset, tire=o.tire, pace="hold"))
        if o.sim
        else turn_of_bag(o.bag)
    )
    path = book.path.parent / f"parasitic_{o.mounting}_{o.date}.yaml"
    hub = from_mapping(HubParameters, {**in_force(book, HUB), FIT: ""}, HUB)
    left = identify_turn(turn, o.mounting, o.date, path, hub)
    for name, (before, after) in left.items():
        print(f"{name}: {before:.1f} N once per turn, {after:.2f} N after the filter")
    most = max(after for _, after in left.values())
    entry = Entry("parasitic", o.date, {FIT: path.name}, most, unit="N")
    return write_entry(book, entry)


def filter_effect(o: argparse.Namespace, book: CalibrationBook) -> Result:
    """Print what the parasitic filter leaves under load and slip, from two equal runs or --sim."""

    from flatplank_control.bench.results import read_samples
    from flatplank_control.calibration.fits import amplitude_lines, amplitudes_under_load

    if o.sim:
        setup = BenchSetup(preset=o.preset, tire=o.tire, pace="hold")
        fit = book.fit()
        found = {k: simulator().filter_on_twin(setup, fit, k) for k in (0.0, -0.05)}
        for kappa, amplitudes in found.items():
            print(f"slip {100 * kappa:+g} %")
            print("  " + "\n  ".join(amplitude_lines(amplitudes)))
        return {"amplitudes": {f"{k:g}": amplitudes for k, amplitudes in found.items()}}
    if o.plain is None or o.filtered is None:
        raise ValueError("filter: give --plain and --filtered, two equal runs, or --sim")
    runs = [read_samples(path).columns for path in (o.plain, o.filtered)]
    left = amplitudes_under_load(runs[0], runs[1], o.first, o.last)
    print("\n".join(amplitude_lines(left)))
    return {"amplitudes": dict(left)}


def status(o: argparse.Namespace, book: CalibrationBook) -> Result:
    """Print which calibrations are valid; exit code 1 when one is expired or absent."""
    found = book.status(date.fromisoformat(o.date))
    for name, text in found.items():
        print(f"{name:14} {text}")
    return {"valid": all(text.startswith("valid") for text in found.values()), "status": found}


def sheet(o: argparse.Namespace, book: CalibrationBook) -> Result:
    """Print an empty pre-flight sheet, or the starting values of a filled one."""
    if o.file is None:
        text = empty_sheet(o.date)
        print(text, end="")
        return {"sheet": text}
    values = starting_values(o.file.read_text(encoding="utf-8"), str(o.file))
    print(dump_yaml({"effects": values}), end="")
    return {"effects": values}


WORK: dict[str, Work] = {
    "hub": hub, "lvdt": lvdt, "plank": plank, "motor": motor, "friction": friction,
    "parasitic": parasitic,
    "filter": filter_effect,
    "status": status, "sheet": sheet,
}  # fmt: skip


def write_entry(book: CalibrationBook, entry: Entry) -> Result:
    """Write an entry to the book and print it."""
    book.add(entry)
    for name, value in entry.parameters.items():
        error = entry.uncertainty.get(name)
        shown = value if error is None else f"{value:.6g}"
        print(f"{name}: {shown}" + (f" +- {error:.2g}" if error else ""))
    print(f"residual {entry.residual:.3g} {entry.unit}; put down in {book.path}")
    return asdict(entry)


def parser() -> argparse.ArgumentParser:
    p = Parser(prog="flatplank calibrate", description=__doc__)
    p.add_argument("--book", type=Path, default=Path(FILE), help="file of the calibrations")
    p.add_argument("--date", default=date.today().isoformat(), help="ISO 8601; default: today")
    add_json(p)
    what = p.add_subparsers(dest="what", required=True)
    for name, work in WORK.items():
        one = what.add_parser(name, help=work.__doc__)
        if name in ("hub", "lvdt", "plank", "motor"):
            one.add_argument("--pairs", required=True, help="known:read,known:read,...")
            one.add_argument("--reading", type=float, default=0.0, help="uncertainty of a reading")
        if name == "hub":
            one.add_argument("--axis", required=True, choices=HUB_AXES)
        if name == "parasitic":
            one.add_argument("--mounting", required=True, help="name of this mounting")
            one.add_argument("--bag", type=Path, help="of an unloaded turn")
            one.add_argument("--sim", action="store_true", help="on the twin")
        if name == "filter":
            one.add_argument("--plain", type=Path, help="a run without the filter")
            one.add_argument("--filtered", type=Path, help="the same run with it")
            one.add_argument("--first", type=float, default=2.0, help="from here on [m]")
            one.add_argument("--last", type=float, default=4.0, help="to here [m]")
            one.add_argument("--sim", action="store_true", help="on the twin, with the fit in use")
        if name == "friction":
            one.add_argument("--bag", type=Path, nargs="+", help="unloaded, several speeds")
            one.add_argument("--sim", action="store_true", help="on the twin")
        if name in ("friction", "parasitic", "filter"):
            one.add_argument("--tire", default="toyo", help="of the twin")
            one.add_argument("--preset", default="", help="of the twin: thesis2023")
        if name == "sheet":
            one.add_argument("file", type=Path, nargs="?", help="a filled sheet")
    return p


def main(argv: list[str]) -> int:
    """Run the command; 0: done; 1: a calibration is expired or absent."""
    o = parser().parse_args(argv)
    with for_programs(o.json) as found:
        found |= WORK[o.what](o, CalibrationBook(o.book.resolve()))
    return 0 if found.get("valid", True) else 1
