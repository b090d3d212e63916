# SPDX-License-Identifier: Apache-2.0
"""A run record says by itself what it was measured with, whoever asked for it."""

from __future__ import annotations

import datetime
import math
import re
import subprocess
from pathlib import Path

import pytest

from flatplank_control.bench.setup import BenchSetup
from flatplank_control.calibration.book import INSTRUMENTS, CalibrationBook, Entry
from flatplank_control.runner import provenance, steps
from flatplank_control.runner.provenance import ASKED, MEASURING, complete_record, software_version
from flatplank_data.params import parameter_infos
from flatplank_data.run_record import RunRecord, load_record, record_from_dict
from flatplank_sim.twin.log import BagLog
from flatplank_sim.twin.twin import Twin
from flatplank_sim.twin.twin_bench import TwinBench

TODAY = datetime.date(2026, 5, 31)
DESCRIBED = record_from_dict({"tire": "TOY", "parameters": {"session": {"paper_batch": "7"}}})


def of(setup: BenchSetup) -> RunRecord:
    book = CalibrationBook(Path(setup.calibration))
    return complete_record(DESCRIBED, Twin(setup).in_force(), book, TODAY)


def test_a_bench_as_it_comes_is_told_shortly():
    record = of(BenchSetup(preset="thesis2023", seed=7))
    assert record.plant == {"tire": "toyo", "preset": "thesis2023", "config": "", "seed": 7}
    assert record.parameters["session"] == {"paper_batch": "7"}
    assert record.parameters.keys() == {"session"}
    assert record.calibration["motor"] == {"status": "absent", "gear_ratio": 1425.04}
    assert record.slip_angle_offset_deg == 0.0


def test_what_is_unusual_is_told():
    own = {"slip_sequencer": {"road_scale": 1.0013}, "measurement_hub": {"et_value": 0.031}}
    record = of(BenchSetup(parameters=own))
    assert record.parameters["slip_sequencer"]["road_scale"] == 1.0013
    assert record.et_value == 0.031  # has a place of its own
    assert "measurement_hub" not in record.parameters


@pytest.mark.parametrize("emulated", [True, False])
def test_a_real_machine_has_no_plant(emulated):
    in_force = Twin(BenchSetup()).in_force()
    machine = in_force.pop("simulated_plant")
    in_force |= {"ethercat_bus": machine} if emulated else {}
    record = complete_record(DESCRIBED, in_force, CalibrationBook(Path("")), TODAY)
    assert (record.plant is not None) == emulated


def test_nodes_that_are_not_there_are_left_out():
    record = complete_record(DESCRIBED, {}, CalibrationBook(Path("")), TODAY)
    assert math.isnan(record.et_value) and record.plant is None
    assert set(record.parameters) == {"session"}
    assert record.calibration["motor"] == {"status": "absent"}


@pytest.mark.parametrize("node", sorted(MEASURING))
def test_every_node_takes_what_is_calibrated_of_its_parameters(node):
    own = {p.name for p in parameter_infos(MEASURING[node])}
    for name, instrument in INSTRUMENTS.items():
        shared = own.intersection(instrument.parameters)
        assert bool(shared) == (node in instrument.nodes), name
        assert shared in (set(), set(instrument.parameters)), name


def test_a_calibrated_ratio_reaches_all_who_use_it(tmp_path):
    book = CalibrationBook(tmp_path / "c.yaml")
    book.add(Entry("motor", "2026-05-01", {"gear_ratio": 1420.0}, 0.0))
    setup = BenchSetup(calibration=str(book.path))
    motor = {"status": "valid: of 2026-05-01", "gear_ratio": 1420.0}
    assert of(setup).calibration["motor"] == motor
    in_force = Twin(setup).in_force()
    assert {in_force[node]["gear_ratio"] for node in INSTRUMENTS["motor"].nodes} == {1420.0}
    in_force["slip_sequencer"]["gear_ratio"] = 1425.04
    status = complete_record(DESCRIBED, in_force, book, TODAY).calibration["motor"]["status"]
    assert status.startswith("not in force")


def test_everything_that_is_asked_for_exists():
    in_force = Twin(BenchSetup()).in_force()
    for node in MEASURING:
        assert set(ASKED[node]) == set(in_force[node])
    assert set(ASKED["simulated_plant"]) <= set(in_force["simulated_plant"])


def test_the_version_has_the_commit_of_the_repository():
    inside = ["git", "-C", str(Path(provenance.__file__).resolve().parent), "rev-parse", "HEAD"]
    commit = subprocess.run(inside, capture_output=True, text=True, check=True).stdout.strip()
    said = re.fullmatch(r"\d+\.\d+\.\d+ \((\w+)(, changed)?\)", software_version())
    assert said and commit.startswith(said[1])


def test_without_git_the_version_is_that_of_the_package(monkeypatch):
    software_version.cache_clear()
    monkeypatch.setenv("PATH", "")
    assert re.fullmatch(r"\d+\.\d+\.\d+", software_version())
    software_version.cache_clear()


def test_the_twin_writes_it_into_the_bag(tmp_path):
    bench = TwinBench(Twin(BenchSetup(seed=3)), BagLog(tmp_path))
    bench.perform([
        steps.Record({"tire": "TOY", "name": "by_hand", "measurement": "manual"}, at_once=True),
        steps.Wait("some samples", lambda _s: True, 2.0, 1.0),
        steps.StopRecord("complete", ""),
    ])  # fmt: skip
    record = load_record(bench.kept[0])
    assert record.plant["seed"] == 3 and record.software_version == software_version()
    assert record.et_value is not None and record.calibration["motor"]["status"] == "absent"
