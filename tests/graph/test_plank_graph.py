# SPDX-License-Identifier: Apache-2.0
"""A slip run with a driven plank on the graph: its node makes what the switch asked for."""

from __future__ import annotations

from pathlib import Path

import pytest
from bench_graph import graph
from test_twin import decoded

from flatplank_control.bench.setup import BenchSetup
from flatplank_control.runner.measurement import Measurement
from flatplank_control.runner.plans import plan_of
from flatplank_sim.twin.log import BagLog
from flatplank_sim.twin.twin import Twin
from flatplank_sim.twin.twin_bench import TwinBench

pytestmark = pytest.mark.graph
SLIP = Measurement(kappa=-0.05, start=2, step_position=0.02, end_position=0.08)


def test_the_plank_is_driven_by_its_node_as_on_the_twin(tmp_path, monkeypatch):
    plan = {k: v for k, v in vars(SLIP).items() if v not in ("", {}, None)}
    with graph(tmp_path, monkeypatch, axes=("plank",)) as bench:
        assert "plank_drive" in bench.names()
        (bag,) = bench.client.measure(plan, simulated=True)
    folder = tmp_path / "twin"
    folder.mkdir()
    twin = TwinBench(Twin(BenchSetup(pace="hold", axes=("plank",))), BagLog(folder))
    twin.perform(plan_of(SLIP))
    ours, theirs = decoded(Path(bag)), decoded(twin.kept[0])
    for topic in ("/encoders/state", "/measurement_hub/state", "/wheel_drive/status"):
        assert len(ours[topic]) > 600, topic
        assert ours[topic] == theirs[topic], topic
    assert any("frame_id='plank'" in text for _, text in ours["/bus/outputs"])
