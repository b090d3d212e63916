# SPDX-License-Identifier: Apache-2.0
"""What a goal asks for is done, told how far it is, or refused before anything moves."""

from __future__ import annotations

import time

import pytest
from bench_graph import shared_graph
from std_srvs.srv import Trigger

from flatplank_control.nodes.client import BenchError
from flatplank_control.runner.dry_run import dry_run_progress
from flatplank_control.runner.measurement import from_mapping
from flatplank_control.runner.plans import plan_of
from flatplank_data.run_record import load_record
from flatplank_hw.nodes.qos import STREAM
from flatplank_hw.troubles import TROUBLES
from flatplank_msgs.action import RunMeasurement
from flatplank_msgs.msg import BusInputs, EncoderState

pytestmark = pytest.mark.graph
bench = shared_graph()
SHORT = {"kappa": 0.02, "step_position": 0.02, "end_position": 0.06}
LONG = {"kappa": 0.05, "step_position": 0.3, "end_position": 3.9}


def test_a_goal_without_a_wish_moves_nothing_and_names_no_recorder(bench):
    cycles: list[int] = []
    bench.client.node.create_subscription(
        BusInputs, "/bus/inputs", lambda m: cycles.append(m.cycle), STREAM
    )
    last = bench.advance(10)
    said = bench.processes.log.read_text(encoding="utf-8")
    kept = list(bench.data.glob("*"))
    for text, reason in {
        "": "empty; state what to measure",
        "{}": "empty; state what to measure",
        "just text": "'just text' is no plan",
        "{fz: 3700}": "not what to measure",
        "{kapa: 1}": "unknown key 'kapa'",
    }.items():
        with pytest.raises(BenchError, match=".") as refused:
            bench.client.measure(text, simulated=True)
        assert reason in str(refused.value) and "\n" not in str(refused.value), text
    bench.client.spin(0.5)
    assert max(cycles) <= last, "the held bus made no cycle for them"
    assert list(bench.data.glob("*")) == kept
    log = bench.processes.log.read_text(encoding="utf-8").removeprefix(said)
    assert "/recorder/stop" not in log
    assert log.count(TROUBLES["refused"].text) == 4, "the two empty ones are the same"


def test_a_single_measurement_says_how_far_it_is(bench):
    said: list[str] = []
    sent = bench.listen(
        RunMeasurement.Impl.FeedbackMessage, "/run_measurement/_action/feedback"
    )  # of which a client that is held up loses some
    bench.client.measure(SHORT, simulated=True, say=said.append)
    while not sent or sent[-1].feedback.progress <= 0.8:
        bench.client.spin(0.5)
    heard = [(m.feedback.progress, m.feedback.time_left) for m in sent]
    assert said and all(a != b for a, b in zip(said, said[1:], strict=False))
    progress, left = zip(*heard, strict=True)
    assert list(progress) == sorted(progress) and list(left) == sorted(left, reverse=True)
    assert progress[0] < 0.1 and len(set(progress)) > 5
    total = dry_run_progress(plan_of(from_mapping(SHORT, "plan"))).total
    assert left[0] == pytest.approx(total) and 0.0 <= left[-1] < 0.2 * total


def test_a_stop_ends_the_measurement_and_the_plank_at_once(bench):
    seen: list[EncoderState] = []
    pressed: list[float] = []
    bench.client.node.create_subscription(EncoderState, "/encoders/state", seen.append, STREAM)

    def press() -> None:
        going = seen and seen[-1].plank_moving and 0.1 < seen[-1].plank_position < 1.0
        if going and said[-1].startswith("slip +5 %") and not pressed:
            bench.call(Trigger, "/wheel_drive/quick_stop")
            pressed.append(seen[-1].plank_position)

    said: list[str] = []
    folder = bench.data / "stopped"
    folder.mkdir()
    with pytest.raises(BenchError, match="the wheel was stopped: quick stop was asked for"):
        bench.client.measure(LONG, simulated=True, folder=str(folder), say=said.append, idle=press)
    last = bench.advance(200)
    end = time.monotonic() + 30.0
    while seen[-1].cycle < last and time.monotonic() < end:
        bench.client.spin(0.2)
    assert not seen[-1].plank_moving
    assert seen[-1].plank_position < 0.5 * LONG["end_position"]
    (bag,) = [path.parent for path in folder.glob("*/run.yaml")]
    record = load_record(bag)
    assert record.status == "stopped" and "quick stop" in record.stop_reason
