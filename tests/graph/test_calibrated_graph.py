# SPDX-License-Identifier: Apache-2.0
"""The nodes have the constants of the book and the rim of the plan; the run record states them."""

from __future__ import annotations

from pathlib import Path

import pytest
from bench_graph import Graph, graph

from flatplank_control.calibration.book import CalibrationBook, Entry
from flatplank_control.runner.provenance import software_version
from flatplank_data.run_record import RunRecord, load_record
from flatplank_msgs.srv import StartRecording, StopRecording

pytestmark = pytest.mark.graph
SEED = 4
PLAN = """
measurement: stiffness_longitudinal
distance: 0.01
et_value: 0.055
"""


def test_the_record_states_what_the_nodes_have(tmp_path, monkeypatch):
    book = CalibrationBook(tmp_path / "c.yaml")
    book.add(Entry("hub_fz", "2020-01-01", {"k_fz1": 2.0, "k_fz2": 1.95}, 0.1))
    changed = {"slip_sequencer": {"follow_until": 0.2}}
    setup = {"calibration": str(book.path), "parameters": changed}
    with graph(tmp_path, monkeypatch, seed=SEED, **setup) as bench:
        book.add(Entry("lvdt", "2020-01-01", {"lvdt_gain": 0.021, "lvdt_offset": 0.3}, 0.0))
        (bag,) = bench.client.measure(PLAN, simulated=True)
        by_hand = recorded_by_hand(bench)
    record = load_record(Path(bag))
    assert (record.et_value, record.adapter_thickness) == (0.055, 0.02)
    assert record.slip_angle_offset_deg == 0.0
    hub = record.calibration["hub_fz"]
    assert hub["status"].startswith("expired: of 2020-01-01") and hub["k_fz1"] == 2.0
    lvdt = record.calibration["lvdt"]
    assert lvdt["status"].startswith("not in force") and lvdt["lvdt_gain"] == 0.02
    assert record.calibration["motor"] == {"status": "absent", "gear_ratio": 1425.04}
    assert record.plant == {"tire": "toyo", "preset": "", "config": "", "seed": SEED}
    assert record.software_version == software_version()
    # whoever asks for a bag gets the same record of the bench
    for key in ("calibration", "plant", "software_version", "et_value", "parameters"):
        assert getattr(by_hand, key) == getattr(record, key), key
    assert record.parameters == changed


def recorded_by_hand(bench: Graph) -> RunRecord:
    """A bag by service calls, with no more said than the name of the tire."""
    started = bench.call(
        StartRecording, "/recorder/start", name="by_hand", record="tire: TOY", at_once=True
    )
    bench.advance(50)
    bench.call(StopRecording, "/recorder/stop", status="complete")
    return load_record(Path(started.path))
