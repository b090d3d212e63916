# SPDX-License-Identifier: Apache-2.0
"""Measurements of the demo: some on the real graph, the rest of the campaign on the twin."""

from __future__ import annotations

import os
from pathlib import Path

from flatplank_analysis.data import Campaign
from flatplank_analysis.steady.rolling_radius import radius_of_run
from flatplank_control.bench.campaign import SLIPS, matrix, simulate_many
from flatplank_control.bench.listing import write_campaign, write_tire
from flatplank_control.bench.processes import BenchProcesses
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.demo.steps import Teller
from flatplank_control.runner.campaign.tires import known_tires
from flatplank_control.runner.measurement import Measurement

LOOPBACK = {
    "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
    "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4",
}
FREE_ROLLING = Measurement(measurement="free_rolling", end_position=2.2, run_index=0)
SLIP_ON_GRAPH = (0.05, 1)
"""slip and start of the run that is made on the graph"""
STARTS = (1, 2, 3)


def on_the_graph(folder: Path, seed: int, teller: Teller) -> float:
    """A free-rolling run, then a slip step by the graph's action; the radius that it found [m]."""
    from flatplank_control.nodes.client import BenchClient

    folder.mkdir(parents=True, exist_ok=True)
    teller.step("the ROS graph on the simulated bench: free rolling, then a slip step, a bag each")
    for key, value in LOOPBACK.items():
        os.environ.setdefault(key, value)
    setup = BenchSetup(pace="hold", seed=seed, data=str(folder))
    with BenchProcesses(setup, log=folder.parent / "nodes.log") as bench, BenchClient() as client:
        client.wait_connected(bench, say=teller.now)
        radius = _radius(client, folder, teller)
        teller.now(f"effective rolling radius by (5.22): {radius:.4f} m")
        kappa, start = SLIP_ON_GRAPH
        slip = Measurement(
            kappa=kappa, start=start, effective_rolling_radius=radius, r_e_source="controller"
        )
        _measure(client, slip, folder, teller)
    return radius


def _radius(client, folder: Path, teller: Teller) -> float:
    path = _measure(client, FREE_ROLLING, folder, teller)
    (run,) = [r for r in Campaign.load(folder).runs if r.info.name == path.name]
    return radius_of_run(run.table()).radius


def _measure(client, m: Measurement, folder: Path, teller: Teller) -> Path:
    plan = {k: v for k, v in vars(m).items() if v not in ("", {})}
    bags = client.measure(plan, simulated=True, folder=str(folder), say=teller.now)
    path = Path(bags[-1])
    write_campaign(folder, m.tire, [(m.record(), path.name)])
    return path


def on_the_twin(folder: Path, seed: int, radius: float, jobs: int | None, teller: Teller) -> None:
    """The other runs of nine slips and three starts."""
    base = Measurement(effective_rolling_radius=radius, r_e_source="controller")
    runs = [m for m in matrix(base, SLIPS, STARTS) if (m.kappa, m.start) != SLIP_ON_GRAPH]
    teller.step(f"the other {len(runs)} slip steps on the twin, a bag each")
    setup = BenchSetup(pace="hold", seed=seed)
    simulate_many(runs, setup, folder, bags=True, jobs=jobs, progress=teller.count)
    write_tire(folder, known_tires()[base.tire].record)
