# SPDX-License-Identifier: Apache-2.0
"""The held graph and the twin give the same samples, bit for bit."""

from dataclasses import asdict
from pathlib import Path

import pytest
from bench_graph import graph
from rosbags.highlevel import AnyReader

from flatplank_control.bench.setup import BenchSetup
from flatplank_control.nodes.ros_bench import ATTEMPTS
from flatplank_control.recording.topics import RECORDED, at_every_cycle
from flatplank_control.recording.typestore import typestore
from flatplank_control.road_map import RoadMap, with_road
from flatplank_control.runner.measurement import Measurement
from flatplank_control.runner.plans import plan_of
from flatplank_control.runner.steps import Snapshot
from flatplank_data.run_record import load_record
from flatplank_sim.twin.log import BagLog
from flatplank_sim.twin.twin import Twin
from flatplank_sim.twin.twin_bench import TwinBench

pytestmark = pytest.mark.graph
SEED = 5
SOURCE_TOPICS = {
    "slip": {"/slip_sequencer/state", "/wheel_drive/reference"},
    "free_rolling": {"/free_rolling_controller/state", "/wheel_drive/reference"},
}
FAST = 10
"""cycles in a batch while a held bench is prepared"""
ITS_OWN = {"uuid", "started", "ended"}
"""what no two runs have in common"""
EVERY_CYCLE = {
    spec.name
    for spec in RECORDED
    if spec.name not in ("/wheel_drive/mode", "/diagnostics")
    and not any(spec.name in topics for topics in SOURCE_TOPICS.values())
}


def decoded(bag: Path) -> dict[str, list[tuple[int, str]]]:
    """Messages by topic; repr of a float is exact."""
    found: dict[str, list[tuple[int, str]]] = {}
    with AnyReader([bag], default_typestore=typestore()) as reader:
        for connection, stamp, raw in reader.messages():
            text = repr(reader.deserialize(raw, connection.msgtype))
            found.setdefault(connection.topic, []).append((stamp, text))
    return found


def on_twin(setup: BenchSetup, measurement: Measurement, folder: Path, more: int = 0) -> Path:
    """Bag of the twin, which makes `more` batches before its first samples are looked at."""
    folder = folder / f"twin{more}"
    folder.mkdir()
    twin = TwinBench(Twin(setup), BagLog(folder))
    look = twin._look_again

    def first() -> Snapshot:
        del twin._look_again
        twin.advance(more)
        return look()

    twin._look_again = first
    twin.perform(plan_of(measurement))
    return twin.kept[0]


@pytest.mark.parametrize("kind, map_of_the_road", [
    ("slip", None), ("slip", RoadMap(1.0015, 40e-6, -10e-6, 20e-6, 5e-6)), ("free_rolling", None),
])  # fmt: skip
def test_graph_and_twin_record_the_same(kind, map_of_the_road, tmp_path, monkeypatch):
    setup = BenchSetup(pace="hold", seed=SEED)
    if map_of_the_road:
        map_of_the_road.save(tmp_path / "road.yaml")
        setup = with_road(setup, str(tmp_path / "road.yaml"))
    measurement = Measurement(
        measurement=kind, kappa=-0.05, start=2, step_position=0.02, end_position=0.08
    )
    plan = {k: v for k, v in vars(measurement).items() if v != "" and v != {}}
    with graph(tmp_path, monkeypatch, seed=SEED, parameters=setup.parameters) as bench:
        (bag,) = bench.client.measure(plan, simulated=True)
    twin = on_twin(setup, measurement, tmp_path)
    if more := load_record(Path(bag)).cycle_first - load_record(twin).cycle_first:
        # the first samples came before DDS had connected the runner, which asked for further ones
        batches, rest = divmod(more, FAST)
        assert rest == 0 and 0 < batches < ATTEMPTS
        twin = on_twin(setup, measurement, tmp_path, batches)
    records = [load_record(path) for path in (Path(bag), twin)]
    used = [{k: v for k, v in asdict(r).items() if k not in ITS_OWN} for r in records]
    assert used[0] == used[1]
    if map_of_the_road:
        said = records[0].parameters["slip_sequencer"]
        assert map_of_the_road.parameters().items() <= {"tooth_pitch": 0.01571, **said}.items()
    ours, theirs = decoded(Path(bag)), decoded(twin)
    topics = EVERY_CYCLE | SOURCE_TOPICS[kind]
    assert topics == set(at_every_cycle(kind))  # the recorder waits for these before it closes
    assert topics <= set(ours) & set(theirs)
    for topic in sorted(topics):
        assert len(ours[topic]) > 600, topic
        assert ours[topic] == theirs[topic], topic
