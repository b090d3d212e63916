# SPDX-License-Identifier: Apache-2.0
"""Every criterion of the verdict finds its own fault and only that."""

from __future__ import annotations

import numpy as np
import pytest

from flatplank_control.runner.campaign.quality import (
    Limits,
    force_profile,
    judge_run,
    loaded_travel,
)
from flatplank_control.runner.dry_run import DryBench
from flatplank_control.runner.measurement import Measurement
from flatplank_control.runner.moves import ENOUGH, SLOW, SPEED
from flatplank_control.runner.plans import plan_of
from flatplank_control.runner.steps import Manual, Plank, StopRecord, Wait


def run(**change) -> dict[str, np.ndarray]:
    """Samples of a good slip run of 5 % at 1.5 m, with something changed."""
    x = np.arange(0.0, 4.1, 0.002)
    angle = x / 0.31
    fx = np.where(x < 1.5, 0.0, 3700.0 * -np.expm1(-(x - 1.5) / 0.4))
    fx = fx + change.get("drifting", 0.0) * x
    dead = change.get("dead", 0.0)
    fx = np.where((x > 1.5) & (x < 1.5 + dead), 0.0, fx)
    fz = 3700.0 * (1.0 + change.get("load", 0.0) + change.get("sinks", 0.0) * x / 4.0)
    fz = fz + change.get("turn", 0.0) * np.sin(angle + 0.7)
    speed = np.full(x.size, 0.03092 * (1.0 + change.get("speed", 0.0)))
    return {"plank_position": x, "wheel_angle": angle, "plank_velocity": speed,
            "fx": fx, "fz": fz}  # fmt: skip


FAULTS = {
    "settling": {"drifting": 800.0},
    "load_error": {"load": 0.1},
    "load_drift": {"sinks": -0.1},
    "speed_error": {"speed": 0.02},
    "once_per_turn": {"turn": 200.0},
    "plateau": {"dead": 0.4},
}
M = Measurement(kappa=0.05)


def test_a_good_run_is_good():
    verdict = judge_run(run(), M, Limits())
    assert verdict.ok and verdict.text() == "good"


def test_a_slow_run_is_judged_by_its_own_speed():
    columns = run()
    assert not judge_run(columns, Measurement(kappa=0.05, speed=SLOW), Limits()).ok
    columns["plank_velocity"] = columns["plank_velocity"] * SLOW / SPEED
    assert judge_run(columns, Measurement(kappa=0.05, speed=SLOW), Limits()).ok


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_found_and_named(name):
    verdict = judge_run(run(**FAULTS[name]), M, Limits())
    assert [f.name for f in verdict.findings if not f.ok] == [name]
    assert verdict.text().startswith(name)


def test_the_amplitude_over_a_turn_is_the_true_one():
    found = {f.name: f.value for f in judge_run(run(turn=200.0), M, Limits()).findings}
    assert found["once_per_turn"] == pytest.approx(200.0, rel=0.01)


def test_a_run_unlike_its_repeats_is_found():
    earlier = [force_profile(run())] * 2
    assert judge_run(run(), M, Limits(), earlier).ok
    other = judge_run(run(dead=0.2), M, Limits(repeatability=100.0), earlier)
    assert [f.name for f in other.findings if not f.ok] == ["repeatability"]


def until(end: float, columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Stopped by hand: the plank brakes and rests for a while."""
    seen = {name: values[columns["plank_position"] <= end] for name, values in columns.items()}
    rest = {name: np.full(100, values[-1]) for name, values in seen.items()}
    rest["plank_velocity"] = np.zeros(100)
    return {name: np.append(values, rest[name]) for name, values in seen.items()}


def test_a_slip_run_that_the_operator_ended_is_judged_up_to_there():
    stopped = judge_run(until(2.5, run()), M, Limits(), enough=True)
    assert (
        stopped.text() == "good; ended at 2.50 m; not evaluated: road too short for once_per_turn"
    )
    assert stopped.ok and stopped.plain()["ended"] == 2.5
    for name in ("settling", "load_error", "speed_error", "plateau"):
        bad = judge_run(until(2.5, run(**FAULTS[name])), M, Limits(), enough=True)
        assert [f.name for f in bad.findings if not f.ok] == [name]
    assert judge_run(until(1.2, run()), M, Limits(), enough=True).left_out == (
        "settling", "once_per_turn", "plateau",
    )  # fmt: skip


def test_a_road_that_ended_by_itself_is_no_good_run():
    assert not judge_run(until(2.5, run()), M, Limits()).ok


def test_free_rolling_that_the_operator_ended_is_judged_up_to_there():
    free = Measurement(measurement="free_rolling")
    columns = run()
    columns["fx"] = np.full_like(columns["fx"], 50.0)
    stopped = judge_run(until(2.0, columns), free, Limits(), enough=True)
    assert stopped.text() == "good; ended at 2.00 m" and not stopped.left_out
    columns["fx"] += 10.0
    bad = judge_run(until(2.0, columns), free, Limits(), enough=True)
    assert [f.name for f in bad.findings if not f.ok] == ["force_error"]


def test_the_operators_wish_is_in_the_record():
    """The road was not seen to its end: only then."""
    at = DryBench().snapshot()
    for x, said in ((4.2, ""), (2.5, ENOUGH)):
        for step in plan_of(Measurement()):
            if isinstance(step, Wait) and step.may_end_early:
                moving = at.encoders._replace(plank_position=x, plank_moving=True)
                assert step.until(at._replace(encoders=moving)) == (not said)
            if isinstance(step, StopRecord):
                assert (step.status, step.notes) == ("complete", said)


def test_a_dry_run_knows_the_slow_speed_and_that_flexplates_are_no_angle():
    bench = DryBench()
    bench.perform([Plank(1, fast=False)])
    assert bench.snapshot().encoders.plank_velocity == SLOW
    times = []
    for quantity in ("flexplates", "pressure_bar"):
        bench = DryBench()
        bench.perform([Manual(quantity, 1.0)])
        times.append(bench.time)
    assert times[0] == times[1]


def test_the_travel_is_that_of_the_loaded_tire():
    columns = run()
    assert loaded_travel(columns) == pytest.approx(4.1, abs=0.01)
    columns["fz"] = np.where(columns["plank_position"] < 1.0, 3700.0, 100.0)
    assert loaded_travel(columns) == pytest.approx(1.0, abs=0.01)
    assert loaded_travel({**columns, "fz": np.zeros_like(columns["fz"])}) == 0.0


def test_free_rolling_must_hold_the_reference_of_its_controller():
    columns = run()
    free = Measurement(measurement="free_rolling")
    columns["fx"] = np.full_like(columns["fx"], 50.0)
    assert judge_run(columns, free, Limits()).ok
    columns["fx"] += 10.0
    assert "force_error" in judge_run(columns, free, Limits()).text()
    assert judge_run(columns, free, Limits(), reference=60.0).ok
    assert "force_error" in judge_run(columns, free, Limits(), reference=0.0).text()
