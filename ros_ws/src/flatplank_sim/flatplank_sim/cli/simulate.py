# SPDX-License-Identifier: Apache-2.0
"""Measure a campaign in one process, 60 times real time."""

from __future__ import annotations

import argparse
import math
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path

from flatplank_analysis.models.tire_record import TireRecord
from flatplank_analysis.steady.rolling_radius import radius_of_run
from flatplank_control.bench.results import read_samples, write_tire
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.cli.run import main as run_plan
from flatplank_control.runner.campaign.tires import tire_of_plant
from flatplank_control.runner.measurement import Measurement
from flatplank_data.arguments import Parser, add_json, for_programs
from flatplank_data.campaign import Campaign
from flatplank_sim.cli.reveal import read_diagnosis
from flatplank_sim.plant.config import PlantConfig
from flatplank_sim.sealed.generate import make_challenge, measure_next, more_runs
from flatplank_sim.sealed.menu import OUTSIDE
from flatplank_sim.sealed.score import DIAGNOSIS
from flatplank_sim.twin.campaign import SLIPS, simulate_many, slips_by_starts, starts_of

COMPATIBLE_OPTIONS = {
    "hidden": ({"outside", "jobs"}, "--hidden has a campaign of its own; leave it out"),
    "more": (
        {"slips", "starts", "at", "jobs"},
        "--more measures the machine of a challenge, with slips, starts and step of your own; "
        "leave the others out",
    ),
    "next": (set(), "--next makes the run that a diagnosis proposes; leave it out"),
    "plan": (
        {"preset", "plant", "seed", "bags", "jobs"},
        "with --plan it is set in the plan; leave it out, or write it into a plan of your own",
    ),
}
"""option that selects the measurements -> compatible options, and the message for others"""


def parser() -> argparse.ArgumentParser:
    p = Parser(prog="flatplank simulate", description=__doc__)
    p.add_argument("folder", type=Path, help="campaign folder; made when it is not there")
    p.add_argument("--plan", help="a campaign plan, shipped or a file, as `flatplank run --sim`")
    p.add_argument("--slips", help="slips [%%] with commas; default: the nine of the thesis")
    p.add_argument("--starts", default="1,2,3", help="1,2,3: wheel at 0, 120, 240 deg")
    p.add_argument("--free-rolling", action="store_true", help="controller runs instead of slips")
    p.add_argument("--tire", default="toyo", help="toyo, continental, michelin, racing")
    p.add_argument("--name", help="of the tire in the files; default: its own (TOY, CON, ...)")
    p.add_argument("--fz", type=float, help="[N]; default: the tire's nominal load")
    p.add_argument("--pressure", type=float, help="[bar]; default: the tire's nominal pressure")
    p.add_argument("--alpha", type=float, default=0.0, help="side slip angle [deg]")
    p.add_argument("--gamma", type=float, default=0.0, help="camber [deg]")
    p.add_argument(
        "--re",
        type=float,
        help="effective rolling radius [m]; default: the tire's where it is known, else a "
        "free-rolling run gives it",
    )
    p.add_argument("--at", type=float, default=1.5, help="plank position of the step [m]")
    p.add_argument("--preset", default="", help="defects of the machine, for instance thesis2023")
    p.add_argument("--plant", default="", help="YAML file laid over the plant's own")
    p.add_argument("--seed", type=int, default=1)
    p.add_argument("--rate", type=int, default=250, help="bus rate [Hz]")
    p.add_argument("--bags", action="store_true", help="rosbag2 bags instead of tables")
    p.add_argument(
        "--hidden",
        type=int,
        metavar="SEED",
        help="a challenge: something is hidden, the answer sealed",
    )
    p.add_argument(
        "--outside",
        choices=sorted(OUTSIDE),
        default="",
        help="with --hidden: a force that is in no library",
    )
    p.add_argument(
        "--more",
        type=Path,
        metavar="CHALLENGE",
        help="further runs of the machine of a challenge, for confirm and next runs",
    )
    p.add_argument(
        "--next",
        action="store_true",
        help=f"in a challenge: the next run that its {DIAGNOSIS} proposes, added to its runs",
    )
    p.add_argument("--jobs", type=int, help="processes; default: all cores")
    add_json(p)
    return p


def plan_arguments(o: argparse.Namespace) -> list[str]:
    """Arguments of `flatplank run` for the same options."""
    words = [o.plan, "--sim", "--data", str(o.folder), "--seed", str(o.seed)]
    for name in ("preset", "plant"):
        if getattr(o, name):
            words += [f"--{name}", getattr(o, name)]
    if o.jobs:
        words += ["--jobs", str(o.jobs)]
    return [*words, *["--bags"] * o.bags, *["--json"] * o.json]


def refuse_ignored_options(argv: list[str]) -> None:
    """Raise ValueError for options without effect next to --hidden, --more or --plan."""
    names = vars(parser().parse_args(argv))
    values = vars(parser().parse_args(argv, argparse.Namespace(**dict.fromkeys(names))))
    given = [name for name, value in values.items() if value is not None and name != "folder"]
    for selector, (compatible, text) in COMPATIBLE_OPTIONS.items():
        ignored = [
            f"--{n.replace('_', '-')}" for n in given if n not in compatible | {selector, "json"}
        ]
        if selector in given and ignored:
            raise ValueError(f"{', '.join(ignored)}: {text}")


def slips_of(text: str | None) -> list[float]:
    if text is None:
        return list(SLIPS)
    try:
        return [float(word) / 100.0 for word in text.split(",")]
    except ValueError:
        raise ValueError(f"--slips '{text}': give slips in % with commas, as in -5,0,5") from None


def print_progress(done: int, count: int, name: str) -> None:
    """Print the progress in one line that is overwritten."""
    end = "\n" if done == count else ""
    clear = "\r\033[K" if sys.stderr.isatty() else "\n" if done > 1 else ""
    print(f"{clear}simulate {done}/{count} {name}", end=end, file=sys.stderr, flush=True)


def main(argv: list[str]) -> int:
    """Make all runs and return 0."""
    o = parser().parse_args(argv)
    refuse_ignored_options(argv)
    if o.plan is not None:
        return run_plan(plan_arguments(o))
    with for_programs(o.json) as found:
        simulate(o)
        if o.json:
            files = [run.info.file for run in Campaign.load(o.folder).runs]
            found |= {"folder": str(o.folder.resolve()), "files": files}
    return 0


def simulate(o: argparse.Namespace) -> None:
    """Make all runs of the options."""
    if o.outside and o.hidden is None:
        raise ValueError("--outside hides something: give --hidden SEED, too")
    if o.hidden is not None:
        make_challenge(o.folder, o.hidden, print_progress, o.outside)
        print(
            f"challenge in {o.folder}; then: flatplank diagnose {o.folder} --out "
            f"{o.folder}/diagnosis.json, and flatplank reveal {o.folder}"
        )
        return
    if o.more is not None:
        further = [(kappa, start) for kappa in slips_of(o.slips) for start in starts_of(o.starts)]
        more_runs(o.folder, o.more, further, o.at, print_progress)
        print(f"{len(further)} runs of the machine of {o.more} in {o.folder}")
        return
    if o.next:
        make_next(o.folder)
        return
    setup = BenchSetup(
        tire=o.tire, preset=o.preset, plant_file=o.plant, seed=o.seed, rate_hz=o.rate, pace="hold"
    )
    record, radius = tire_and_radius(o)
    base = Measurement(
        tire=record.name,
        measurement="free_rolling" if o.free_rolling else "slip",
        fz=record.nominal_load if o.fz is None else o.fz,
        pressure=record.nominal_pressure if o.pressure is None else o.pressure,
        alpha_deg=o.alpha,
        gamma_deg=o.gamma,
        step_position=o.at,
    )
    starts = starts_of(o.starts)
    slips = [0.0] if o.free_rolling else slips_of(o.slips)
    make = partial(
        simulate_many, setup=setup, folder=o.folder, bags=o.bags, progress=print_progress
    )
    before: list[Measurement] = []
    if not o.free_rolling:
        if not math.isfinite(radius):
            before = [replace(base, measurement="free_rolling", start=starts[0])]
            (path,) = make(before, jobs=1)
            radius = radius_of_run(read_samples(path)).radius
            print(f"effective rolling radius by a free-rolling run: {radius:.4f} m")
        base = replace(base, effective_rolling_radius=radius)
    runs = [
        replace(m, run_index=m.run_index + len(before))
        for m in slips_by_starts(base, slips, starts)
    ]
    make(runs, jobs=o.jobs)
    write_tire(o.folder, record)
    print(f"{len(before) + len(runs)} runs in {o.folder}")


def make_next(folder: Path) -> None:
    """Make the run that the diagnosis of a challenge proposes; ValueError without a proposal."""
    path = folder / DIAGNOSIS
    proposal = read_diagnosis(path, folder).get("next_run") or {}
    if not proposal.get("settings"):
        raise ValueError(f"{path}: {proposal.get('what', 'no next run is needed')}")
    measure_next(folder, proposal["settings"], proposal["repeats"], print_progress)
    print(f"{proposal['what']}: added to {folder}; then: flatplank diagnose {folder} --out {path}")


def tire_and_radius(o: argparse.Namespace) -> tuple[TireRecord, float]:
    """Record of the mounted tire, and its effective rolling radius [m]; NaN: unknown."""
    entry = tire_of_plant(o.tire)
    if entry is None:  # a file of the user
        t = PlantConfig.load(o.tire).tire
        record = TireRecord(t.name, t.free_radius, t.nominal_load, t.nominal_pressure_bar)
    else:
        record = entry.record
    record = replace(record, name=o.name or record.name)
    usual = {"fz": record.nominal_load, "pressure": record.nominal_pressure}
    nominal = all(getattr(o, k) in (None, v) for k, v in usual.items()) and not (
        o.alpha or o.gamma
    )
    known = entry.effective_rolling_radius if entry and nominal else math.nan
    return record, known if o.re is None else o.re
