# SPDX-License-Identifier: Apache-2.0
"""Measure a campaign on the twin: the bench's own cores in one process, without ROS."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from flatplank_control.bench.campaign import SLIPS, matrix, simulate_many, starts_of
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.blind.outside import OUTSIDE
from flatplank_control.cli.run import main as run_plan
from flatplank_control.runner.measurement import Measurement
from flatplank_control.sealed.generate import make_challenge


def parser() -> argparse.ArgumentParser:
    p = argparse.ArgumentParser(prog="flatplank simulate", description=__doc__)
    p.add_argument("folder", type=Path, help="campaign folder; made when it is not there")
    p.add_argument("--plan", help="a campaign plan, shipped or a file, as `flatplank run --sim`")
    p.add_argument("--slips", help="slips [%%] with commas; default: the nine of the thesis")
    p.add_argument("--starts", default="1,2,3", help="1,2,3: wheel at 0, 120, 240 deg")
    p.add_argument("--free-rolling", action="store_true", help="controller runs instead of slips")
    p.add_argument("--tire", default="toyo", help="toyo, continental, michelin, racing")
    p.add_argument("--name", default="TOY", help="of the tire in the files")
    p.add_argument("--fz", type=float, default=3700.0, help="[N]")
    p.add_argument("--pressure", type=float, default=2.5, help="[bar]")
    p.add_argument("--alpha", type=float, default=0.0, help="side slip angle [deg]")
    p.add_argument("--gamma", type=float, default=0.0, help="camber [deg]")
    p.add_argument("--re", type=float, default=0.3108, help="effective rolling radius [m]")
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
    p.add_argument("--jobs", type=int, help="processes; default: all cores")
    return p


def plan_arguments(o: argparse.Namespace) -> list[str]:
    """The same wish for `flatplank run`."""
    words = [o.plan, "--sim", "--data", str(o.folder), "--seed", str(o.seed)]
    for name in ("preset", "plant"):
        if getattr(o, name):
            words += [f"--{name}", getattr(o, name)]
    if o.jobs:
        words += ["--jobs", str(o.jobs)]
    return [*words, "--bags"] if o.bags else words


def slips_of(text: str | None) -> list[float]:
    if text is None:
        return list(SLIPS)
    try:
        return [float(word) / 100.0 for word in text.split(",")]
    except ValueError:
        raise ValueError(f"--slips '{text}': give slips in % with commas, as in -5,0,5") from None


def show(done: int, count: int, name: str) -> None:
    """One line that is written over."""
    end = "\n" if done == count else ""
    clear = "\r\033[K" if sys.stderr.isatty() else "\n" if done > 1 else ""
    print(f"{clear}simulate {done}/{count} {name}", end=end, file=sys.stderr, flush=True)


def main(argv: list[str]) -> int:
    """Exit code 0: all runs are there."""
    o = parser().parse_args(argv)
    if o.outside and o.hidden is None:
        raise ValueError("--outside hides something: give --hidden SEED, too")
    if o.hidden is not None:
        make_challenge(o.folder, o.hidden, show, o.outside)
        print(
            f"challenge in {o.folder}; then: flatplank diagnose {o.folder} --out "
            f"{o.folder}/diagnosis.json, and flatplank reveal {o.folder}"
        )
        return 0
    if o.plan is not None:
        return run_plan(plan_arguments(o))
    base = Measurement(
        tire=o.name,
        measurement="free_rolling" if o.free_rolling else "slip",
        fz=o.fz,
        pressure=o.pressure,
        alpha_deg=o.alpha,
        gamma_deg=o.gamma,
        effective_rolling_radius=o.re,
        step_position=o.at,
    )
    setup = BenchSetup(
        tire=o.tire, preset=o.preset, plant_file=o.plant, seed=o.seed, rate_hz=o.rate, pace="hold"
    )
    slips = [0.0] if o.free_rolling else slips_of(o.slips)
    runs = matrix(base, slips, starts_of(o.starts))
    simulate_many(runs, setup, o.folder, bags=o.bags, jobs=o.jobs, progress=show)
    print(f"{len(runs)} runs in {o.folder}")
    return 0
