# SPDX-License-Identifier: Apache-2.0
"""Actual slip keeps within 0.05 % of the desired, judged against the road that no node can
read."""

from __future__ import annotations

import math
import re
from dataclasses import asdict

import numpy as np
import pytest

from flatplank_control.road_map import RoadMap, Run, check_wheel_followed, identify_road_map
from flatplank_validation.bench.start_bench import StartBench
from flatplank_validation.bench.start_cases import driven
from flatplank_validation.truth import truth_row

FZ, PRESSURE = 3700.0, 2.5


@pytest.fixture(scope="module")
def road() -> RoadMap:
    bench = StartBench("toyo")
    truth = truth_row(bench.config, FZ, PRESSURE)
    run, _ = driven(0.0, 3.2, follow_until=100.0)
    return identify_road_map([run], truth.standstill_stiffness_x, truth.relaxation_length_x)


def test_the_map_is_learnt_from_the_force_of_a_run_without_slip(road, tmp_path):
    assert road.road_scale == pytest.approx(1.0015, abs=1.5e-4)
    assert math.hypot(road.mesh_turn_cos, road.mesh_turn_sin) == pytest.approx(40e-6, rel=0.25)
    assert math.hypot(road.mesh_tooth_cos, road.mesh_tooth_sin) == pytest.approx(20e-6, rel=0.25)
    road.save(tmp_path / "road.yaml")
    assert RoadMap.load(tmp_path / "road.yaml") == road


@pytest.mark.parametrize("kappa", [0.1, 0.05])
def test_slip_is_right_over_every_turn_of_the_pinion(road, kappa, capsys):
    _, ours = driven(kappa, 2.2, follow_until=100.0, road_scale=road.road_scale)
    _, thesis = driven(kappa, 2.2)
    errors = [float(np.abs(slips - kappa).max()) for slips in (thesis, ours)]
    with capsys.disabled():
        print(
            f"\nkappa {100 * kappa:+g} %: error over a turn {100 * errors[0]:.3f} % "
            f"at constant speed, {100 * errors[1]:.4f} % from the road's travel"
        )
    assert errors[1] < 5e-4 < errors[0]


def test_a_map_takes_the_error_of_a_measured_radius_along(capsys):
    """The run that gives r_e is made with the same encoder, and at 50 N instead of none."""
    bench = StartBench("toyo")
    truth = truth_row(bench.config, FZ, PRESSURE)
    wrong = 1.002
    run, _ = driven(0.0, 3.2, wrong, follow_until=100.0)
    road = identify_road_map([run], truth.standstill_stiffness_x, truth.relaxation_length_x)
    _, slips = driven(0.05, 2.2, wrong, follow_until=100.0, **road.parameters())
    error = float(np.abs(slips - 0.05).max())
    with capsys.disabled():
        print(f"\nr_e 0.2 % wrong, map of its own runs: slip within {100 * error:.4f} %")
    assert error < 5e-4


def test_the_mesh_is_fed_back(road):
    def once_per_turn(run: Run) -> float:
        keep = run.position > 0.8
        x = run.position[keep]
        basis = np.column_stack([np.ones_like(x), x, np.cos(x / 0.05), np.sin(x / 0.05)])
        a = np.linalg.lstsq(basis, run.fx[keep], rcond=None)[0]
        return float(np.hypot(a[2], a[3]))

    plain, _ = driven(0.0, 2.2, follow_until=100.0, road_scale=road.road_scale)
    with_mesh, slips = driven(0.0, 2.2, follow_until=100.0, **road.parameters())
    assert once_per_turn(with_mesh) < 0.4 * once_per_turn(plain)
    assert float(np.abs(slips).max()) < 5e-4


def test_a_road_encoder_needs_no_map():
    _, slips = driven(0.05, 2.2, road_encoder=True, follow_until=100.0)
    assert float(np.abs(slips - 0.05).max()) < 5e-4


def test_bad_input_is_refused():
    with pytest.raises(ValueError, match="give kappa = 0 runs"):
        identify_road_map([], 2e5, 0.4)


@pytest.mark.parametrize("sequencer, rolled", [({"follow_until": 100.0}, ""), ({}, r"0\.99\d\d")])
def test_only_runs_whose_wheel_followed_the_encoder_are_taken(sequencer, rolled):
    run, _ = driven(0.0, 2.2, **sequencer)
    radius = truth_row(StartBench("toyo").config, FZ, PRESSURE).effective_rolling_radius
    if not rolled:
        check_wheel_followed(run, radius, "a.parquet")
        return
    with pytest.raises(ValueError, match=f"a.parquet: the wheel rolled {rolled}.*--road follow"):
        check_wheel_followed(run, radius, "a.parquet")


def test_the_end_of_a_run_tells_nothing(road):
    """The plank stands and the wheel goes on for a moment."""
    truth = truth_row(StartBench("toyo").config, FZ, PRESSURE)
    run, _ = driven(0.0, 3.2, follow_until=100.0)
    count = 25
    ended = Run(
        np.append(run.position, np.full(count, run.position[-1])),
        np.append(run.wheel_angle, run.wheel_angle[-1] + 4e-4 * np.arange(count)),
        np.append(run.fx, np.linspace(0.0, 600.0, count)),
    )
    check_wheel_followed(ended, truth.effective_rolling_radius, "a.parquet")
    assert (
        identify_road_map([ended], truth.standstill_stiffness_x, truth.relaxation_length_x) == road
    )


@pytest.mark.parametrize("text, said", [
    (None, "cannot be read"),
    ("road_scale: [", "not YAML"),
    ("- 1.0", "no road map"),
    ("road_scale: 1.0", "it has no force_left"),
    ("{whole}turn: 1.0", "unknown parameter 'turn'"),
    ("{whole}road_scale: fast", "road_scale must be a number"),
    ("{whole}road_scale: 3.0", "road_scale"),
])  # fmt: skip
def test_a_bad_map_is_told_in_one_line(tmp_path, text, said):
    path = tmp_path / "road.yaml"
    if text is not None:
        whole = "".join(f"{key}: {value}\n" for key, value in asdict(RoadMap()).items())
        path.write_text(text.replace("{whole}", whole))
    with pytest.raises(ValueError, match=re.escape(said)) as refused:
        RoadMap.load(path)
    assert str(refused.value).startswith(str(path)) and "\n" not in str(refused.value)
