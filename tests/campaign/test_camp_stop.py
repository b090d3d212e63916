# SPDX-License-Identifier: Apache-2.0
"""A measurement ends when the wheel is stopped on the way, with plank and bag in order."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest

from flatplank_analysis.report.analysis import analyse
from flatplank_control.bench.setup import BenchSetup
from flatplank_control.recording.filled import in_words, requested_record
from flatplank_control.runner import steps as S
from flatplank_control.runner.measurement import Measurement
from flatplank_control.runner.plans import plan_of
from flatplank_control.runner.steps import StopDetector
from flatplank_data.campaign import Campaign
from flatplank_data.errors import NothingUsableError
from flatplank_data.run_record import load_record
from flatplank_hw.drive.safety import LEFT_OPERATION, QUICK_STOP, RULES
from flatplank_hw.samples import DriveSample
from flatplank_hw.troubles import TROUBLES
from flatplank_sim.twin.log import BagLog
from flatplank_sim.twin.twin import Twin
from flatplank_sim.twin.twin_bench import TwinBench

RUN = Measurement(kappa=0.05, step_position=0.3, end_position=2.0)


def sample(reason: int) -> DriveSample:
    return DriveSample(*(0,) * 10, reason, 0)


def test_a_new_stop_ends_the_plan_and_an_old_one_does_not():
    watch = StopDetector()
    for reason in (QUICK_STOP, QUICK_STOP, 0, RULES["plank_stands"].code, 0):
        watch.check_sample(sample(reason))
    with pytest.raises(S.PlanFailed, match=TROUBLES["left_operation"].text):
        watch.check_sample(sample(LEFT_OPERATION))
    watch.check_sample(sample(LEFT_OPERATION))


@pytest.mark.parametrize(
    ("step", "ends"), [(S.Plank(1), True), (S.Plank(0), False), (S.Plank(1, stop_at=2.0), False)]
)
def test_a_plank_that_stands_ends_a_plan_that_did_not_stop_it(step: S.Plank, ends: bool):
    watch = StopDetector()
    watch.register_command(step)
    watch.check_sample(sample(0))
    stands = sample(RULES["plank_stopped"].code)
    if ends:
        with pytest.raises(S.PlanFailed, match=TROUBLES["plank_stopped"].text):
            watch.check_sample(stands)
    else:
        watch.check_sample(stands)
        watch.register_command(S.Plank(1))
        watch.check_sample(sample(0))
        with pytest.raises(S.PlanFailed, match=TROUBLES["plank_stopped"].text):
            watch.check_sample(stands)


def test_a_browser_that_dies_in_the_midst_of_a_run_stops_it_and_keeps_it(tmp_path: Path):
    """Its heartbeat is missing: wheel and plank stop, the record says why."""
    twin = Twin(BenchSetup(pace="hold"))
    bench = TwinBench(twin, BagLog(tmp_path))
    assert twin.drive.claim("page").accepted
    turned: list[float] = []
    cycle = twin.cycle

    def with_page():
        made = cycle()
        if turned or (bench._recording and made.encoders.plank_position > 0.5):
            turned.append(twin.plant.truth.wheel_velocity)
        else:
            twin.drive.heartbeat("page")
        return made

    twin.cycle = with_page
    with pytest.raises(S.PlanFailed, match=TROUBLES["heartbeat"].text):
        bench.perform(plan_of(RUN))
    bench.advance(250)
    last = int(np.flatnonzero(np.abs(turned) > 1e-3)[-1])
    ramp = 0.4  # of a quick stop [s], tests/panel has the same
    assert last / twin.rate_hz < twin.drive.parameters.heartbeat_timeout + ramp
    assert twin.plant.truth.road_velocity == pytest.approx(0.0, abs=1e-6)
    record = load_record(bench.kept[0])
    assert record.status == "stopped" and TROUBLES["heartbeat"].text in record.stop_reason


@pytest.mark.parametrize("axes", [(), ("plank",)])
def test_the_plank_stops_with_the_wheel_in_the_midst_of_a_run(tmp_path: Path, axes):
    twin = Twin(BenchSetup(pace="hold", axes=axes))
    bench = TwinBench(twin, BagLog(tmp_path))
    positions: list[float] = []
    stopped_at: list[float] = []
    cycle = twin.cycle

    def watched():
        made = cycle()
        positions.append(made.encoders.plank_position)
        recording = len(positions) > 2 and bench._recording
        if recording and made.encoders.plank_position > 0.5 and not stopped_at:
            stopped_at.append(made.encoders.plank_position)
            twin.drive.quick_stop()
        return made

    twin.cycle = watched
    with pytest.raises(S.PlanFailed, match="the wheel was stopped: quick stop was asked for"):
        bench.perform(plan_of(RUN))
    bench.advance(250)
    moved = positions[-1] - stopped_at[0]
    assert 0.0 < moved < 0.02, "the plank has stopped, far from the end at 2 m"
    assert abs(positions[-1] - positions[-50]) < 1e-4
    record = load_record(bench.kept[0])
    assert record.status == "stopped" and "quick stop was asked for" in record.stop_reason


def test_the_driven_plank_stops_by_itself_before_anybody_looks(tmp_path: Path):
    """The rule of its own drive; no plan is needed for it."""
    twin = Twin(BenchSetup(pace="hold", axes=("plank",)))
    bench = TwinBench(twin, BagLog(tmp_path))
    plan = plan_of(RUN)
    going = itertools.takewhile(
        lambda s: not (isinstance(s, S.Wait) and s.what.startswith("the plank is at 2")), plan
    )
    for step in going:
        bench._do[type(step)](step)
    bench.advance(1000)
    before = twin.latest.encoders.plank_position
    twin.drive.quick_stop()
    bench.advance(100)
    plank = twin.axes["plank"].sample
    assert plank.stop_reason == RULES["wheel_stopped"].code
    assert not twin.latest.encoders.plank_moving
    assert twin.latest.encoders.plank_position - before < 0.01
    assert not twin.drive.troubles.get("drag")
    bench._stop_record(S.StopRecord("stopped"))


def test_a_wheel_that_stops_in_a_run_by_hand_is_told_by_its_record(tmp_path: Path):
    """Nobody describes the run, watches it, or says how it ended; the plank goes on."""
    twin = Twin(BenchSetup(pace="hold"))
    log = BagLog(tmp_path)
    bench = TwinBench(twin, log)
    plan = plan_of(RUN)
    going = itertools.takewhile(
        lambda s: not (isinstance(s, S.Wait) and s.what.startswith("the plank is at 2")), plan
    )
    for step in going:
        bench._do[type(step)](step)
    bench.advance(5000)
    stopped = twin.latest.encoders.plank_position
    twin.drive.quick_stop()
    bench.advance(2500)
    assert twin.latest.encoders.plank_position > stopped + 0.2
    log._flush()
    record = log._session.stop("complete", fill=requested_record("").filled_in)
    assert record.status == "stopped"
    told = record.stop_reason
    assert told.startswith(f"the wheel was stopped at {stopped:.2f} m: ") and "quick stop" in told
    assert (record.kappa, record.step_position) == (0.05, 0.3)
    assert record.effective_rolling_radius == pytest.approx(0.3108)
    assert "slip +5 %, from 0.3 m" in in_words(record)
    with pytest.raises(NothingUsableError, match="left out: it ended as 'stopped'.*quick stop"):
        Campaign.load(tmp_path)
    # the bag by its own path is evaluated up to the stop
    assert log._session.path is not None
    campaign = Campaign.load(log._session.path)
    (table,) = campaign.tables()
    assert stopped - 0.01 < table["plank_position"][-1] < stopped + 0.01
    result = analyse(campaign, nonlinear=False, magic=False)
    assert [r.radius for r in result.radii] == pytest.approx([0.3108], rel=5e-3)
    assert any("quick stop" in str(p) for p in result.problems)
