# SPDX-License-Identifier: Apache-2.0
"""A slip run by services alone, without a record: recorder and analysis know what it was."""

from pathlib import Path

import pytest
import yaml
from bench_graph import graph
from diagnostic_msgs.msg import DiagnosticArray
from mcap.reader import make_reader
from std_srvs.srv import SetBool, Trigger

from flatplank_analysis.report.analysis import analyse
from flatplank_control.recording.topics import RECORDED, at_every_cycle
from flatplank_data.campaign import Campaign
from flatplank_data.errors import NothingUsableError
from flatplank_data.run_record import load_record
from flatplank_hw.nodes.convert import raw_stamp_ns
from flatplank_msgs.srv import (
    PlankSwitch,
    SetOperationMode,
    SetPace,
    SetSlipStep,
    SetValue,
    SetWaveform,
    StartRecording,
    StopRecording,
)

pytestmark = pytest.mark.graph
STEP = {"kappa": 0.05, "start_position": 0.12, "effective_rolling_radius": 0.3108}

SINE = {
    "name": "sine", "parameters": ["amplitude", "wavelength"], "values": [0.03, 0.4],
    "start_position": 0.12, "effective_rolling_radius": 0.3108,
}  # fmt: skip


def offered(bench) -> dict[str, dict[str, object]]:
    """Quality of service of every recorded topic, as its publishers tell the graph."""
    found = {}
    for spec in RECORDED:
        profiles = [
            info.qos_profile for info in bench.client.node.get_publishers_info_by_topic(spec.name)
        ]
        for qos in profiles:
            seconds, nanoseconds = divmod(qos.deadline.nanoseconds, 10**9)
            found[spec.name] = {
                "reliability": qos.reliability.name.lower(),
                "durability": qos.durability.name.lower(),
                "deadline": {"sec": seconds, "nsec": nanoseconds},
            }
    return found


def stored(bag: Path) -> dict[str, dict[str, object]]:
    """The same as the bag's metadata have it, of topics with messages."""
    content = yaml.safe_load((bag / "metadata.yaml").read_text())
    topics = content["rosbag2_bagfile_information"]["topics_with_message_count"]
    return {
        t["topic_metadata"]["name"]: t["topic_metadata"]["offered_qos_profiles"][0]
        for t in topics
        if t["message_count"]
    }


def roll_by_hand(bench, stop_after: int = 0, wave: str = "step") -> StopRecording.Response:
    """What docs/guide/lab.md has people type; four cycles a message make it short.

    stop_after: cycles of the rolling wheel after which its drive is stopped; 0: it is not.
    """
    bench.call(SetPace, "/simulated_plant/set_pace", pace="hold", batch=10)
    bench.advance(100)
    bench.call(SetValue, "/simulated_plant/load_to", value=3700.0)
    bench.advance(4000)
    if wave == "step":
        bench.call(SetSlipStep, "/slip_sequencer/set_slip_step", **STEP)
    else:
        bench.call(SetWaveform, "/slip_sequencer/set_waveform", **SINE)
    bench.call(SetOperationMode, "/wheel_drive/set_operation_mode", mode="slip")
    bench.call(SetBool, "/wheel_drive/enable", data=True)
    path = bench.call(StartRecording, "/recorder/start").path
    told = bench.listen(DiagnosticArray, "/diagnostics")
    assert path == str(bench.data.absolute() / "by_hand")
    bench.call(SetPace, "/simulated_plant/set_pace", pace="hold", batch=4)
    bench.call(PlankSwitch, "/simulated_plant/plank", direction=1, fast=True, stop_at=0.5)
    if stop_after:
        bench.advance(stop_after)
        bench.call(Trigger, "/wheel_drive/quick_stop")
    bench.advance(3600 - stop_after)
    while len(told) < 2:  # told every second of real time, in which a fast computer is done
        bench.client.spin(0.2)
    return bench.call(StopRecording, "/recorder/stop")


def test_a_run_by_services_is_recorded_and_evaluated_as_what_it_was(tmp_path, monkeypatch):
    with graph(tmp_path, monkeypatch) as bench:
        said = roll_by_hand(bench)
        wanted = offered(bench)
    bag = Path(said.path)
    assert said.reason.startswith(
        "slip +5 %, from 0.12 m, r_e 310.8 mm, Fz 3700 N, tire unknown, pressure not given, 0 of "
    )
    record = load_record(bag)
    assert (record.status, record.tire, record.kappa) == ("complete", "unknown", 0.05)
    assert (record.effective_rolling_radius, record.step_position) == (0.3108, 0.12)
    assert (record.fz, record.start, record.cycles_lost) == (3700.0, 1, 0)
    result = analyse(Campaign.load(bench.data), nonlinear=False)
    (condition,) = result.points[0].conditions
    assert condition.condition.kappa == 0.05 and condition.condition.fz == 3700.0
    assert condition.facts.kappa_actual == pytest.approx(0.05, abs=5e-4)
    (radius,) = result.radii
    # over the first 12 cm after a start from rest; across the step it would be 5 % less
    assert radius.radius == pytest.approx(0.3108, rel=6e-3)
    kept = stored(bag)
    assert {"/wheel_drive/mode", "/wheel_drive/reference", "/diagnostics"} <= kept.keys()
    for topic in kept.keys() & wanted.keys():
        assert kept[topic].items() >= wanted[topic].items(), topic


def test_a_run_by_services_with_a_stop_in_it_says_so(tmp_path, monkeypatch):
    """The plank drags the stopped wheel on: the record, its answer, and every analysis know. The
    waveform is recorded with its name and parameters."""
    with graph(tmp_path, monkeypatch) as bench:
        said = roll_by_hand(bench, 2800, wave="sine")
    assert said.reason.startswith("the wheel was stopped at 0.3")
    assert "quick stop was asked for; slip sine, from 0.12 m, r_e 310.8 mm" in said.reason
    record = load_record(Path(said.path))
    assert record.waveform == {"name": "sine", "amplitude": 0.03, "wavelength": 0.4, "offset": 0.0}
    assert record.kind == "slip sine"
    assert record.status == "stopped" and "quick stop was asked for" in record.stop_reason
    with pytest.raises(NothingUsableError, match="left out: it ended as 'stopped'.*quick stop"):
        Campaign.load(bench.data)
    campaign = Campaign.load(said.path)
    (table,) = campaign.tables()
    assert 0.3 < table["plank_position"][-1] < 0.4
    assert any("the wheel was stopped" in str(problem) for problem in campaign.problems)


def test_a_run_in_real_time_has_its_late_cycles_and_its_delays(tmp_path, monkeypatch):
    with graph(tmp_path, monkeypatch, pace="realtime") as bench:
        bench.call(StartRecording, "/recorder/start", name="rt", record="tire: T", at_once=True)
        heard = bench.listen(DiagnosticArray, "/diagnostics")
        while sum(s.name == "/simulated_plant" for m in heard for s in m.status) < 2:
            bench.client.spin(0.2)
        said = bench.call(StopRecording, "/recorder/stop", status="complete")
    assert load_record(Path(said.path)).cycles_late is not None
    (file,) = Path(said.path).glob("*.mcap")
    with file.open("rb") as stream:
        found = [(c.topic, m) for _, c, m in make_reader(stream).iter_messages()]
    of_cycles = at_every_cycle("off")
    late = [m for t, m in found if t in of_cycles and m.log_time > m.publish_time]
    assert late and all(raw_stamp_ns(m.data) == m.publish_time for m in late)
    cycle = late[len(late) // 2].publish_time
    received = {t: m.log_time for t, m in found if m.publish_time == cycle}
    assert received["/bus/inputs"] <= received["/bus/outputs"], "the command answers the inputs"
