# SPDX-License-Identifier: Apache-2.0
"""Plans expand to runs in the right order; what cannot be done is refused with line and reason."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest
from camp_plans import HEAD, RUNS, small

from flatplank_control.cli.run import main
from flatplank_control.runner.campaign import PlanError, load_plan, plan_from_text
from flatplank_control.runner.campaign.order import radius_condition
from flatplank_control.runner.campaign.tires import known_tires
from flatplank_control.runner.dry_run import dry_run
from flatplank_control.runner.measurement import Measurement
from flatplank_data.limits import LIMITS
from flatplank_data.params import from_mapping
from flatplank_hw.hub import HubParameters
from flatplank_hw.share import config_file
from flatplank_panel.operator import HANDS
from flatplank_sim.plant.config import PlantConfig

TIRES = config_file("flatplank_control", "tires.yaml")
SHIPPED = sorted((TIRES.parent / "plans").glob("*.yaml"))


@pytest.mark.parametrize("path", SHIPPED, ids=lambda p: p.stem)
def test_a_shipped_plan_can_be_made(path: Path):
    plan = load_plan(path)
    paper = dry_run(plan)
    assert paper.road < 4.2
    assert paper.total > 25.0 * len(plan.runs)


def test_the_full_longitudinal_matrix_of_table_6_2():
    plan = load_plan(next(p for p in SHIPPED if p.stem == "toyo_longitudinal"))
    slips = [r.measurement for r in plan.runs if r.measurement.measurement == "slip"]
    assert len(slips) == 162
    assert Counter((m.fz, m.pressure) for m in slips) == {
        (fz, p): 27 for fz in (1850.0, 3700.0, 5550.0) for p in (2.0, 2.5)
    }


@pytest.mark.parametrize("order", ["as_written", "random"])
def test_r_e_is_measured_before_the_slip_runs_that_need_it(order):
    plan = small(f"order: {order}\nseed: 3\ncommon: {{fz: [1850, 3700]}}\n")
    place = {run.key: k for k, run in enumerate(plan.runs)}
    by_key = {run.key: run for run in plan.runs}
    slips = [run for run in plan.runs if run.measurement.measurement == "slip"]
    assert len(slips) == 8 and len(plan.runs) == 10
    for run in slips:
        assert place[run.needs] < place[run.key]
        assert radius_condition(by_key[run.needs].measurement) == radius_condition(run.measurement)


def test_random_order_is_the_same_each_time_and_another_with_another_seed():
    def keys(seed):
        return [r.key for r in small(f"order: random\nseed: {seed}\n").runs]

    assert keys(1) == keys(1) != keys(2)


def test_a_reference_run_comes_first_and_every_so_often():
    plan = small("reference: {every: 2, measurement: slip, kappa: 0.05}\n")
    roles = [run.role for run in plan.runs]
    assert roles == ["radius", "reference", "run", "run", "reference", "run", "run"]


def test_a_reference_run_is_made_as_the_runs_of_its_plan():
    """Only what it says itself is its own; its r_e is that of its own condition."""
    plan = plan_from_text(
        HEAD.replace("TOY", "CON")
        + "serial: A17\noperator: Ada\nsession: {rim: 6Jx15}\n"
        + "common: {et_value: 0.04, end_position: 3.0, alpha_deg: [5, 0]}\n"
        + "reference: {every: 3, kappa: 0.05}\n"
        + "runs:\n- measurement: slip\n  fz: 2000\n  start: [1, 2]\n",
        "p.yaml",
    )
    radius, reference = (r for r in plan.runs[:2])
    m = reference.measurement
    assert (reference.role, radius.role, reference.needs) == ("reference", "radius", radius.key)
    assert (m.tire, m.fz, m.pressure) == ("CON", 3250.0, 2.8)
    assert (m.kappa, m.alpha_deg, m.end_position, m.et_value) == (0.05, 5, 3.0, 0.04)
    assert (m.serial, m.operator, m.session) == ("A17", "Ada", {"rim": "6Jx15"})
    assert radius_condition(radius.measurement) == radius_condition(m)
    needs = {r.needs for r in plan.runs if r.role == "reference"}
    assert needs == {radius.key}
    assert all(r.needs != radius.key for r in plan.runs if r.measurement.fz == 2000)


def test_the_run_that_gives_r_e_is_made_as_the_run_that_needs_it():
    plan = small(
        "serial: A17\nsession: {rim: 6Jx15}\n"
        "common: {et_value: 0.04, adapter_thickness: 0.02, hold_load: true, end_position: 3.0}\n"
    )
    free, slip = (r.measurement for r in plan.runs[:2])
    assert free.measurement == "free_rolling"
    for name in ("serial", "session", "et_value", "adapter_thickness", "hold_load",
                 "end_position"):  # fmt: skip
        assert getattr(free, name) == getattr(slip, name) != getattr(Measurement(), name)


def test_facts_of_the_session_go_into_every_run_record():
    plan = small("serial: A17\nsession: {room_temperature: 21.5, paper_batch: P3}\n")
    record = plan.runs[1].measurement.record()
    assert record["serial"] == "A17"
    assert record["parameters"]["session"] == {"room_temperature": 21.5, "paper_batch": "P3"}


REFUSED = {
    "load": (RUNS + "  fz: [3700, 9000]\n", 8, "fz is 9000 N, must be within 0 .. 8000"),
    "load of the tire": (
        "runs:\n- measurement: slip\n  fz: 7000\n", 6, "the MIC stands up to 6000 N"
    ),
    "road": (
        RUNS + "  step_position: 4.0\n", 8, "the step needs 0.2 m of road behind 4 m"
    ),
    "long waveform": (
        RUNS + "  waveform: sine\n  waveform_parameters: {amplitude: 0.02, wavelength: 3.0}\n",
        9, "the sine needs 3 m of road behind 1.5 m, there are 2.6 m",
    ),
    "pressure": (RUNS + "  pressure: 4.5\n", 8, "takes 1.5 .. 3.5 bar"),
    "start": (RUNS.replace("[1, 2]", "[1, 7]"), 7, "start is 7, must be 1, 2 or 3"),
    "collision": (
        RUNS + "set_up: {blocked_wheel_angles_deg: [[100, 140]]}\n",
        7, "start 2 (120 deg) collides: 100 .. 140 deg of the wheel are blocked",
    ),
    "key": (RUNS + "  kapa: 0.1\n", 8, "unknown key 'kapa'; the nearest is 'kappa'"),
    "kind": (
        RUNS.replace("measurement: slip", "measurement: slop"), 5, "the nearest is 'slip'"
    ),
    "order": ("order: backwards\n" + RUNS, 4, "order is 'backwards'"),
    "limit": ("quality: {setling: 3}\n" + RUNS, 4, "quality: unknown key 'setling'"),
    "limit below 0": (
        "quality: {settling: -1}\n" + RUNS, 4, "settling is -1; give a number above 0"
    ),
    "quality is no section": ("quality: 3\n" + RUNS, 4, "quality is 3; give keys and values"),
    "blocked through 0 deg": (
        RUNS + "set_up: {blocked_wheel_angles_deg: [[350, 10]]}\n",
        7, "start 1 (0 deg) collides: 350 .. 10 deg",
    ),
    "blocked all around": (
        RUNS + "set_up: {blocked_wheel_angles_deg: [[0, 360]]}\n", 7, "start 2 (120 deg) collides",
    ),
    "blocked for the run that gives r_e": (
        RUNS.replace("[1, 2]", "[2]") + "set_up: {blocked_wheel_angles_deg: [[0, 10]]}\n",
        5, "the run that gives r_e (a free_rolling block of yours takes its place): start 1",
    ),
    "blocked, no pairs": (
        RUNS + "set_up: {blocked_wheel_angles_deg: [100, 130]}\n",
        8, "blocked_wheel_angles_deg is [100, 130]; give pairs of numbers",
    ),
    "key of set_up": (
        RUNS + "set_up: {blocked_wheel_angle_deg: [[0, 10]], steer_limit: 3}\n",
        8, "set_up: unknown key 'steer_limit'; the nearest is 'steer_limit_deg'",
    ),
    "set_up is no section": (RUNS + "set_up: 5\n", 8, "set_up is 5; give keys and values"),
    "steering limit": (
        RUNS + "set_up: {steer_limit_deg: abc}\n", 8,
        "steer_limit_deg is 'abc'; give a number of 0 .. 90",
    ),
    "key of the session": (
        RUNS + "session: {room_temprature: 21}\n", 8,
        "session: unknown key 'room_temprature'; the nearest is 'room_temperature'",
    ),
    "fact of the session": (
        RUNS + "session: {room_temperature: warm}\n", 8,
        "room_temperature is 'warm'; give a number of -20 .. 60",
    ),
    "session is no section": (RUNS + "session: 5\n", 8, "session is 5; give keys and values"),
    "common is no section": (RUNS + "common: 5\n", 8, "common is 5; give keys and values"),
    "common": ("common: {fz: 9000}\n" + RUNS, 4, "fz is 9000 N, must be within 0 .. 8000"),
    "key of common": ("common: {kapa: 1}\n" + RUNS, 4, "common: unknown key 'kapa'"),
    "tire of a block": (RUNS + "  tire: CON\n", 8, "tire does not belong here; write it once"),
    "number of a run": (RUNS + "  run_index: 3\n", 8, "run_index does not belong here; leave it"),
    "repeat": (RUNS + "  repeat: 3\n", 8, "repeat does not belong here; give repeats"),
    "no attempts": (RUNS + "attempts: 0\n", 8, "attempts is 0; give a whole number, 1 or more"),
    "attempts below 0": (RUNS + "attempts: -3\n", 8, "attempts is -3; give a whole number"),
    "attempts in words": (RUNS + "attempts: two\n", 8, "attempts is 'two'; give a whole number"),
    "seed": (RUNS + "seed: [1]\n", 8, "seed is [1]; give a whole number, 0 or more"),
    "empty list": (
        RUNS.replace("[0.0, 0.05]", "[]"), 6, "kappa is an empty list; give values"
    ),
    "no number": (RUNS + "  et_value: abc\n", 8, "et_value is 'abc', must be a number"),
    "millimetres": (RUNS + "  et_value: 40\n", 8, "et_value is 40 m, must be within -0.1 .. 0.2"),
    "no parameters": (
        RUNS + "  waveform_parameters: 3\n", 8, "waveform_parameters is 3, must be keys and values"
    ),
    "truth for a number": (RUNS + "  fz: true\n", 8, "fz is True, must be a number"),
    "no load": (RUNS + "  fz: 0\n", 8, "fz of 0 N: give a load, up to 8000 N"),
    "cleat": (
        "runs:\n- measurement: cleat\n  end_position: 1.8\n",
        6, "end_position of 1.8 m: the cleat is at 2 m, give 2.2 m or more",
    ),
    "impulse after the run": (
        "runs:\n- measurement: turning\n  profile: impulse\n  profile_parameters: {start: 100}\n"
        "  end_position: 2.0\n",
        7, "the impulse needs 101 s, there are 16.2 s",
    ),
    "parking after its time": (
        "runs:\n- measurement: parking\n  profile_time: 10\n", 6,
        "the parking needs 70.6 s, there are 10 s",
    ),
    "no reference": (RUNS + "reference: 20\n", 8, "reference is 20; give keys and values"),
    "reference every 0 runs": (
        RUNS + "reference: {every: 0}\n", 8, "every is 0; give a whole number, 1 or more"
    ),
    "load of the reference": (
        RUNS + "reference:\n  every: 2\n  fz: 9000\n", 10, "fz is 9000 N, must be within 0 .. 8000"
    ),
    "key of the reference": (
        RUNS + "reference: {kapa: 1}\n", 8, "reference: unknown key 'kapa'"
    ),
    "blocked for the reference": (
        RUNS.replace("[1, 2]", "[2]") + "  effective_rolling_radius: 0.31\nr_e: given\n"
        "reference: {every: 9}\nset_up: {blocked_wheel_angles_deg: [[0, 10]]}\n",
        10, "start 1 (0 deg) collides",
    ),
    "no repeats": (RUNS + "  repeats: 0\n", 8, "repeats is 0; give a whole number of 1 .. 1000"),
    "a number too large": (RUNS + f"  fz: 1{400 * '0'}\n", 8, "must be finite"),
    "a limit too large": (f"quality: {{settling: 1{400 * '0'}}}\n" + RUNS, 4, "above 0"),
    "no r_e": ("r_e: given\n" + RUNS, 6, "r_e is given: write effective_rolling_radius [m] here"),
    "block": (RUNS + "- 5\n", 4, "runs: block 2 is 5; give keys and values"),
    "no blocks": ("runs: []\n", 4, "runs: nothing to measure; give a list of blocks"),
    "serial": (RUNS + "serial: [1]\n", 8, "serial is [1]; give text"),
    "name": (RUNS + "# no file name\n", 2, "name: 'a/b': not a name"),
    "twice": (RUNS + "  kappa: 0.1\n", 8, "'kappa' is given twice"),
    "not YAML": ("runs: [\n", 5, "correct the file"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_done_is_refused_with_line_and_reason(name, tmp_path, capsys):
    body, line, reason = REFUSED[name]
    head = HEAD.replace("TOY", "MIC") if "MIC" in reason else HEAD
    head = head.replace("small", "a/b") if "a/b" in reason else head
    plan = tmp_path / "p.yaml"
    plan.write_text(head + body)
    assert main([str(plan), "--dry-run"]) == 2
    refused = capsys.readouterr().err.splitlines()[1:]
    assert any(p.startswith(f"{plan}:{line}: ") and reason in p for p in refused), refused


def test_a_start_is_blocked_by_its_own_angle_alone():
    plan = small(
        "set_up: {blocked_wheel_angles_deg: [[350, 355], [20, 110], [-250, -130]]}\n",
        RUNS.replace("[1, 2]", "[1, 3]"),
    )
    assert {r.measurement.start for r in plan.runs} == {1, 3}


def test_an_unknown_tire_names_the_nearest_one():
    with pytest.raises(PlanError, match=r"p.yaml:3: unknown tire 'TOYY'; the nearest is 'TOY'"):
        plan_from_text(HEAD.replace("TOY", "TOYY") + RUNS, "p.yaml")


def test_all_that_is_wrong_is_said_at_once():
    with pytest.raises(PlanError) as error:
        plan_from_text(HEAD + RUNS + "  fz: 9000\n  pressure: 9\n", "p.yaml")
    assert len(error.value.problems) >= 1
    with pytest.raises(PlanError) as error:
        plan_from_text(HEAD + RUNS + "  pressure: 4.5\n  step_position: 4.0\n", "p.yaml")
    assert len(error.value.problems) == 2


def test_the_command_refuses_before_anything_moves(tmp_path, capsys):
    plan = tmp_path / "bad.yaml"
    plan.write_text(HEAD + RUNS + "  fz: 9000\n")
    assert main([str(plan), "--sim", "--data", str(tmp_path / "d")]) == 2
    said = capsys.readouterr().err
    assert f"{plan}:8: fz is 9000" in said
    assert not (tmp_path / "d").exists()


def test_the_dry_run_says_what_it_takes(tmp_path, capsys):
    plan = tmp_path / "small.yaml"
    plan.write_text(HEAD + RUNS)
    assert main([str(plan), "--dry-run"]) == 0
    said = capsys.readouterr().out
    assert "5 runs (1 radius run, 4 slip) with the TOY" in said
    assert "road 4.10 m of 4.22 m, up to 3700 N" in said


@pytest.mark.parametrize(
    ("gamma", "hub", "refused"),
    [
        (-15.0, 0.0, ""), (15.0, 0.0, ""), (30.0, 30.0, ""), (-45.0, -30.0, ""), (45.0, 30.0, ""),
        (20.0, 0.0, "road_camber_deg is 20 deg, must be within -15 .. 15"),
        (31.0, 31.0, "wheel_camber_deg is 31 deg, must be within -30 .. 30"),
        (-46.0, -30.0, "gamma_deg is -46 deg, must be within -45 .. 45"),
    ],
)  # fmt: skip
def test_camber_is_made_everywhere_or_refused_on_paper(gamma, hub, refused):
    """Plans, hub, panel and simulated road have one table of limits."""
    runs = f"runs:\n- measurement: slip\n  gamma_deg: {gamma:g}\n  wheel_camber_deg: {hub:g}\n"
    axes = PlantConfig.load().axes
    for axis, most in {
        "wheel": axes.wheel_camber_limit_deg,
        "road": axes.road_camber_limit_deg,
    }.items():
        assert HANDS[f"{axis}_camber"][1] == f"{axis}_camber_deg"
        assert (-most, most) == LIMITS[f"{axis}_camber_deg"].bounds
    wheel = {"wheel_camber_deg": hub}
    if not refused:
        dry_run(plan_from_text(HEAD + runs, "p.yaml"))
        assert from_mapping(HubParameters, wheel, "hub").wheel_camber_deg == hub
        return
    with pytest.raises(PlanError) as caught:
        plan_from_text(HEAD + runs, "p.yaml")
    (problem,) = caught.value.problems
    assert refused in problem


@pytest.mark.parametrize("name", ["TOY", "CON", "MIC", "RAC"])
def test_a_plans_tire_is_the_one_on_the_simulated_plant(name):
    entry = known_tires()[name]
    truth = PlantConfig.load(entry.plant).tire
    assert (truth.name, truth.free_radius) == (name, entry.free_radius)
    assert truth.nominal_load == entry.nominal_load
    assert truth.nominal_pressure_bar == entry.nominal_pressure


def test_a_list_of_tires_without_records_is_still_read(tmp_path):
    path = tmp_path / "tires.yaml"
    path.write_text(
        "MINE: {plant: toyo, free_radius: 0.3, nominal_load: 3000.0, nominal_pressure: 2.0, "
        "max_load: 6000.0, pressure_range: [1.5, 3.0]}\n"
    )
    mine = known_tires(path)["MINE"]
    assert (mine.free_radius, mine.record.name, mine.max_load) == (0.3, "MINE", 6000.0)
