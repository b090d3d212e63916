# SPDX-License-Identifier: Apache-2.0
"""Stiffnesses, cleat, locked wheel, parking, turning: shipped plans, shown by the plant."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from pyarrow import parquet

from flatplank_control.bench.setup import BenchSetup
from flatplank_control.cli.run import find_plan
from flatplank_control.runner.campaign import PlanError, load_plan, plan_from_text
from flatplank_control.runner.campaign.quality import EVALUATIONS
from flatplank_control.runner.dry_run import dry_run
from flatplank_control.runner.measurement import Measurement
from flatplank_control.runner.plans import axes_of, plan_of
from flatplank_control.runner.steps import PlanFailed
from flatplank_hw.drive.road_trigger import BIT, RoadTrigger
from flatplank_sim.plant import PlantConfig
from flatplank_sim.twin.log import TableLog
from flatplank_sim.twin.twin import Twin
from flatplank_sim.twin.twin_bench import TwinBench
from flatplank_validation.truth import truth_row


def measured(m: Measurement, folder) -> tuple[dict[str, np.ndarray], Twin]:
    setup = BenchSetup(pace="hold", axes=axes_of(m))
    bench = TwinBench(Twin(setup), TableLog(folder))
    bench.perform(plan_of(m))
    table = parquet.read_table(bench.kept[0]).to_pydict()
    return {name: np.array(values) for name, values in table.items()}, bench.twin


TRUE = {
    "stiffness_vertical": lambda t, c: c.tire.vertical_stiffness,
    "stiffness_longitudinal": lambda t, c: t.standstill_stiffness_x,
    # carcass and bristles in series
    "stiffness_lateral": lambda t, c: (
        1.0
        / (
            1.0 / t.carcass_stiffness_y
            + 1.0 / (2.0 * t.contact_half_length * c.tire.tread_stiffness_y)
        )
    ),
}


@pytest.mark.parametrize(("kind", "alpha"), [
    ("stiffness_vertical", 0.0), ("stiffness_longitudinal", 0.0), ("stiffness_lateral", 40.0),
])  # fmt: skip
def test_a_stiffness_is_that_of_the_plant(kind, alpha, tmp_path, capsys):
    m = Measurement(measurement=kind, alpha_deg=alpha)
    columns, _ = measured(m, tmp_path)
    found = EVALUATIONS[kind](columns, m)["stiffness"]
    config = PlantConfig.load("toyo")
    true = TRUE[kind](truth_row(config, m.fz, m.pressure), config)
    with capsys.disabled():
        print(f"\n{kind}: {found / 1e3:.1f} N/mm, of the plant {true / 1e3:.1f} N/mm")
    assert found == pytest.approx(true, rel=0.05)


def test_a_locked_wheel_tells_friction(tmp_path):
    m = Measurement(measurement="locked_wheel", distance=0.1)
    columns, twin = measured(m, tmp_path)
    friction = EVALUATIONS["locked_wheel"](columns, m)["friction"]
    truth = twin.plant.truth
    assert np.ptp(columns["wheel_angle"]) < 0.02
    assert friction == pytest.approx(twin.plant.config.tire.friction, rel=0.03)
    assert truth.fz == 3700.0 or truth.fz > 3600.0


def test_a_cleat_lifts_the_load_and_the_camera_is_triggered(tmp_path):
    m = Measurement(measurement="cleat", cleat_mm=10.0, end_position=2.2, optical_trigger=0.05,
                    effective_rolling_radius=0.3109)  # fmt: skip
    columns, twin = measured(m, tmp_path)
    x, fz, fx = columns["plank_position"], columns["fz"], columns["fx"]
    assert fz.max() == pytest.approx(3700.0 + 0.010 * 2.13e5, rel=0.03)
    assert abs(x[np.argmax(fz)] - 1.98) < 0.02
    on_it = (x > 1.8) & (x < 2.15)
    assert fx[on_it].min() < -500.0 and fx[on_it].max() > 500.0
    # 0 to 2.2 m, a pulse every 50 mm
    assert twin.drive.road_trigger.pulses == pytest.approx(2.2 / 0.05, abs=2)
    assert not twin.drive.road_trigger.armed


def test_the_trigger_pulses_by_the_road_and_not_at_rest():
    trigger = RoadTrigger()
    assert trigger.step(0.0, True) == 0
    trigger.arm(0.01)
    pulses = [trigger.step(0.0001 * k, True) for k in range(1, 1001)]
    assert sum(pulses) == 10 * BIT == trigger.pulses
    assert trigger.step(5.0, False) == 0
    trigger.arm(0.0)
    assert trigger.step(0.0, False) == BIT


def test_parking_turns_the_standing_tire(tmp_path):
    m = Measurement(measurement="parking", profile_parameters={"amplitude": 0.1, "rate": 0.02},
                    profile_time=22.0)  # fmt: skip
    columns, _ = measured(m, tmp_path)
    steer, mz = columns["steer_angle"], columns["mz"]
    assert steer.max() == pytest.approx(0.1, abs=1e-3) and steer.min() == pytest.approx(
        -0.1, abs=1e-3
    )
    assert np.ptp(mz) > 100.0 and np.ptp(columns["plank_position"]) < 1e-4


@pytest.mark.parametrize(
    ("kind", "profile", "column"),
    [("turning", "impulse", "steer_angle"), ("camber_sweep", "sine", "road_camber")],
)
def test_an_axis_is_led_under_the_rolling_tire(kind, profile, column, tmp_path):
    parameters = {"amplitude": 0.02} | ({"period": 8.0} if profile == "sine" else {})
    m = Measurement(measurement=kind, profile=profile, profile_parameters=parameters,
                    step_position=0.4, end_position=0.8)  # fmt: skip
    columns, _ = measured(m, tmp_path)
    angle = columns[column]
    assert angle.max() == pytest.approx(0.02, abs=0.004)
    assert np.abs(angle[columns["plank_position"] < 0.39]).max() < 1e-3
    assert np.ptp(columns["fy"]) > 20.0


def test_a_bench_without_the_axis_says_what_to_do(tmp_path):
    m = Measurement(measurement="parking")
    bench = TwinBench(Twin(BenchSetup(pace="hold")), TableLog(tmp_path))
    with pytest.raises(PlanFailed, match="the steer axis has no drive: start .* --axes steer"):
        bench.perform(plan_of(m))


@pytest.mark.parametrize(
    ("name", "runs"),
    [
        ("toyo_stiffness", 14),
        ("continental_stiffness", 2),
        ("toyo_cleat", 8),
        ("toyo_steering", 6),
    ],
)
def test_shipped_plans_are_accepted(name, runs):
    plan = load_plan(find_plan(name))
    assert len(plan.runs) == runs
    assert dry_run(plan).total > 25.0 * runs


BAD = {
    "- measurement: stiffness_lateral\n  fz: 3700": "6: alpha of 0 deg: a lateral stiffness",
    "- measurement: parking\n  profile_parameters: {amplitude: 1.5}": "7: the parking reaches 85",
    "- measurement: parking\n  profile: zigzag": "7: profile is 'zigzag'",
    "- measurement: camber_sweep\n  profile: sine\n  profile_parameters: {amplitud: 0.1}":
        "8: profile_parameters: unknown parameter 'amplitud'",
    "- measurement: cleat\n  cleat_mm: 50": "7: cleat_mm is 50 mm, must be within 0 .. 20",
    "- measurement: locked_wheel\n  distance: 4.15": "7: distance",
}  # fmt: skip


@pytest.mark.parametrize("block", BAD)
def test_what_cannot_be_is_refused_with_its_line(block):
    text = f"format: flatplank-plan/1\nname: n\ntire: TOY\nr_e: given\nruns:\n{block}\n"
    with pytest.raises(PlanError) as refused:
        plan_from_text(text, "plan.yaml")
    assert f"plan.yaml:{BAD[block]}" in str(refused.value)


def test_the_load_is_judged_by_the_zero_of_its_wheel_angle(tmp_path):
    """What the preloaded shaft feigns at this angle is known from the look before."""
    from flatplank_control.runner.campaign.supervised import Standstill, supervised

    setup = BenchSetup(pace="hold", preset="thesis2023")
    bench = TwinBench(Twin(setup), TableLog(tmp_path))
    before, after = Standstill("before"), Standstill("after")
    m = replace(Measurement(), measurement="stiffness_longitudinal", start=2)
    loads = []
    for step in supervised(m, before, after):
        bench._do[type(step)](step)
        if getattr(step, "quantity", "") == "load":
            shown = bench.snapshot().hub.fz_filtered
            loads.append((shown - before.zero[1], bench.twin.plant.truth.fz, shown))
    by_zero, true, shown = loads[0]
    assert abs(by_zero - true) < 50.0
    assert math.isfinite(shown)
