# SPDX-License-Identifier: Apache-2.0
"""The held graph and the twin give the same samples, bit for bit."""

import subprocess
import sys
from contextlib import ExitStack
from dataclasses import asdict
from pathlib import Path

import pytest
from bench_graph import graph
from domains import loopback, next_domain
from rosbags.highlevel import AnyReader

from flatplank_control.bench.processes import BenchProcesses
from flatplank_control.bench.setup import EVERY_NODE, BenchSetup
from flatplank_control.nodes.client import BenchClient
from flatplank_control.nodes.ros_bench import ATTEMPTS
from flatplank_control.recording.topics import RECORDED, at_every_cycle
from flatplank_control.recording.typestore import typestore
from flatplank_control.road_map import RoadMap, with_road
from flatplank_control.runner.measurement import Measurement
from flatplank_control.runner.plans import plan_of
from flatplank_control.runner.steps import Snapshot
from flatplank_data.arguments import namespace_of
from flatplank_data.machine import USUAL_RADIUS
from flatplank_data.run_record import RunRecord, load_record
from flatplank_sim.twin.log import BagLog
from flatplank_sim.twin.twin import Twin
from flatplank_sim.twin.twin_bench import TwinBench

pytestmark = pytest.mark.graph
SEED = 5
MAIN = "flatplank_analysis.cli.main"
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
    if not spec.qos.latched
    and spec.name != "/diagnostics"
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


def check_same(bag: Path, setup: BenchSetup, measurement: Measurement, folder: Path) -> RunRecord:
    """The bag of the graph is that of the twin, bit for bit; returns the record."""
    twin = on_twin(setup, measurement, folder)
    if more := load_record(bag).cycle_first - load_record(twin).cycle_first:
        # the first samples came before DDS had connected the runner, which asked for further ones
        batches, rest = divmod(more, FAST)
        assert rest == 0 and 0 < batches < ATTEMPTS
        twin = on_twin(setup, measurement, folder, batches)
    records = [load_record(path) for path in (bag, twin)]
    used = [{k: v for k, v in asdict(r).items() if k not in ITS_OWN} for r in records]
    assert used[0] == used[1]
    ours, theirs = decoded(bag), decoded(twin)
    topics = EVERY_CYCLE | SOURCE_TOPICS[measurement.measurement]
    # the recorder waits for these before it closes
    assert topics == set(at_every_cycle(measurement.measurement))
    assert topics <= set(ours) & set(theirs)
    for topic in sorted(topics):
        assert len(ours[topic]) > 600, topic
        assert ours[topic] == theirs[topic], topic
    return records[0]


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
    record = check_same(Path(bag), setup, measurement, tmp_path)
    if map_of_the_road:
        said = record.parameters["slip_sequencer"]
        assert map_of_the_road.parameters().items() <= {"tooth_pitch": 0.01571, **said}.items()


@pytest.mark.parametrize("separate", [(), pytest.param((EVERY_NODE,), marks=pytest.mark.long)])
def test_two_benches_in_one_domain_are_each_the_twin(separate, tmp_path, monkeypatch):
    """Two namespaces, measured at the same time: no sample and no command goes across."""
    environment = loopback(next_domain())
    for key, value in environment.items():
        monkeypatch.setenv(key, value)
    running, verbs = ExitStack(), {}
    seeds = {"bench1": SEED, "hall/bench2": SEED + 1}
    setups = {
        name: BenchSetup(
            pace="hold", seed=seed, namespace=namespace_of(name), separate=separate,
            data=str(tmp_path / name / "data"),
        )
        for name, seed in seeds.items()
    }  # fmt: skip
    with running:
        for name, setup in setups.items():
            Path(setup.data).mkdir(parents=True)
            log = tmp_path / name / "nodes.log"
            bench = BenchProcesses(setup, environment=environment, log=log)
            running.enter_context(bench)
            with BenchClient(namespace=setup.namespace) as client:
                client.wait_connected(bench)
        for name in setups:
            command = [sys.executable, "-m", MAIN, "slip", "-5", "--namespace", name]
            command += ["--at", "0.02", "--end", "0.08", "--start", "2"]
            verbs[name] = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        said = {name: verb.communicate()[0] for name, verb in verbs.items()}
    measurement = Measurement(
        measurement="slip", kappa=-0.05, start=2, step_position=0.02, end_position=0.08,
        effective_rolling_radius=USUAL_RADIUS, tire="TOY",
    )  # fmt: skip
    for name, setup in setups.items():
        assert verbs[name].returncode == 0, said[name]
        check_same(Path(said[name].splitlines()[-1]), setup, measurement, tmp_path / name)
