# SPDX-License-Identifier: Apache-2.0
"""Measurements of the demo: one slip step on the real graph, the others on the twin."""

from __future__ import annotations

import os
from pathlib import Path

from flatplank_analysis.steady.rolling_radius import radius_of_run
from flatplank_control.bench.listing import write_campaign, write_tire
from flatplank_control.bench.loopback import loopback
from flatplank_control.bench.processes import BenchProcesses
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.runner.campaign.tires import known_tires
from flatplank_control.runner.measurement import Measurement
from flatplank_data.campaign import Campaign
from flatplank_sim.demo.steps import Teller
from flatplank_sim.twin.campaign import SLIPS, matrix, simulate_many

FREE_ROLLING = Measurement(measurement="free_rolling", end_position=2.2, run_index=0)
SLIP_ON_GRAPH = (0.05, 1)
"""slip and start of the run that is made on the graph"""
STARTS = (1, 2, 3)


def measure(folder: Path, seed: int, jobs: int | None, teller: Teller) -> float:
    """One free-rolling run and 27 slip steps, a bag each; the effective rolling radius [m]."""
    from flatplank_control.nodes.client import BenchClient

    setup = BenchSetup(pace="hold", seed=seed, data=str(folder))
    teller.step("a free-rolling run on the twin: the effective rolling radius")
    radius = _free_rolling(folder, setup)
    teller.now(f"effective rolling radius by (5.22): {radius:.4f} m")
    base = Measurement(effective_rolling_radius=radius, r_e_source="controller")
    runs = matrix(base, SLIPS, STARTS)
    (on_graph,) = [m for m in runs if (m.kappa, m.start) == SLIP_ON_GRAPH]
    others = [m for m in runs if m is not on_graph]
    teller.step("one slip step on the ROS graph, recorded in a bag")
    for key, value in loopback().items():
        os.environ.setdefault(key, value)
    with BenchProcesses(setup, log=folder.parent / "nodes.log") as bench, BenchClient() as client:
        client.wait_connected(bench, say=teller.now)
        bag = _on_the_graph(client, on_graph, folder, teller)
    teller.step(f"the other {len(others)} slip steps on the twin, a bag each")
    simulate_many(others, setup, folder, bags=True, jobs=jobs, progress=teller.count)
    write_campaign(folder, base.tire, [(on_graph.record(), bag)])
    write_tire(folder, known_tires()[base.tire].record)
    return radius


def _free_rolling(folder: Path, setup: BenchSetup) -> float:
    (path,) = simulate_many([FREE_ROLLING], setup, folder, bags=True, jobs=1)
    (run,) = [r for r in Campaign.load(folder).runs if r.info.name == path.name]
    return radius_of_run(run.table()).radius


def _on_the_graph(client, m: Measurement, folder: Path, teller: Teller) -> str:
    """Name of the bag."""
    plan = {k: v for k, v in vars(m).items() if v not in ("", {})}
    bags = client.measure(plan, simulated=True, folder=str(folder), say=teller.now)
    return Path(bags[-1]).name
