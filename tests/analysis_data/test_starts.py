# SPDX-License-Identifier: Apache-2.0
"""Means over start angles: one function, and no other way to average runs."""

from __future__ import annotations

import ast
import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from flatplank_analysis import starts as starts_module
from flatplank_analysis.identify.runs import step_run
from flatplank_analysis.report.machine_tables import transmission_table
from flatplank_analysis.report.radii import RadiusPair, free_wheel_text
from flatplank_analysis.report.results import (
    CampaignResult,
    DriveRun,
    FurtherResults,
    PointResult,
    RestRun,
)
from flatplank_analysis.report.steps import radius_points, small_slip_stiffness
from flatplank_analysis.starts import mean_over_starts, value_over_starts
from flatplank_analysis.steady.rolling_radius import RadiusRun, mean_radii
from flatplank_analysis.steady.transmission import DriveState, FrictionTorque, efficiency
from flatplank_data.condition import condition_of

UNEVEN = [1, 1, 1, 1, 2, 3, 3]
"""start positions of runs, one of them made four times"""
ETA, FRICTION, GEAR = 0.392, 1.5, 1425.04


def turning(start: int) -> float:
    """What turns once with the wheel, at its start position."""
    return math.sin(2.0 * math.pi * (start - 1) / 3.0 + 1.2)


def test_what_turns_with_the_wheel_cancels_however_often_a_start_was_made() -> None:
    values = np.array([[5.0 + 3.0 * turning(s), 7.0 - turning(s)] for s in UNEVEN])
    assert mean_over_starts(values, UNEVEN) == pytest.approx([5.0, 7.0], abs=1e-12)
    assert abs(values[:, 0].mean() - 5.0) > 0.5


def test_the_error_is_that_of_the_repeats_where_all_starts_are_there() -> None:
    """Scatter 0.2 in 2000 campaigns, beside a part of 3 that turns with the wheel."""
    random = np.random.default_rng(7)
    found = [
        value_over_starts([3.0 * turning(s) + 0.2 * random.normal() for s in UNEVEN], UNEVEN)
        for _ in range(2000)
    ]
    spread = np.std([v.value for v in found])
    assert math.sqrt(np.mean([v.std_error**2 for v in found])) == pytest.approx(spread, rel=0.05)


def test_without_all_starts_the_error_is_their_scatter() -> None:
    two = value_over_starts([4.0, 6.0, 9.0], [1, 1, 2])
    assert (two.value, two.std_error, two.runs) == (7.0, pytest.approx(2.0), 3)
    one = value_over_starts([4.0, 6.0], [2, 2])
    assert (one.value, one.std_error) == (5.0, pytest.approx(1.0))
    assert math.isnan(value_over_starts([4.0], [1]).std_error)
    lacking = value_over_starts([math.nan, 4.0, 6.0], [1, 2, 3])
    assert (lacking.value, lacking.runs) == (5.0, 2)
    assert value_over_starts([], []).note == "not measured"


def slip(kappa: float, fz: float = 3700.0):
    return condition_of("TOY", "slip", fz, 2.5, 0.0, 0.0, kappa)


def drive_runs(kappa: float, force: float) -> list[DriveRun]:
    """Driving runs whose Fx turns with the wheel by 600 N, behind a gear of 39.2 %."""
    out = []
    for start in UNEVEN:
        tire = 0.3 * (force + 600.0 * turning(start)) / GEAR
        out.append(DriveRun(slip(kappa), DriveState(FRICTION + tire / ETA, tire, 140.0), start))
    return out


def campaign_of(runs: list[DriveRun]) -> CampaignResult:
    curve = FrictionTorque(np.array([0.0, 200.0]), np.full(2, FRICTION), np.full(2, 1e-3))
    rest = [RestRun(2e5 + 1e4 * turning(s), s) for s in UNEVEN]
    point = PointResult(
        slip(0.0).operating_point, (), (), None, further=FurtherResults(rest, runs)
    )
    return CampaignResult("c", "TOY", [point], (), extras={"friction_torque": curve})


def test_the_efficiency_is_that_of_the_means() -> None:
    """At 1 % the turning force is half of the mean: single runs give anything."""
    result = campaign_of([*drive_runs(0.01, 900.0), *drive_runs(0.05, 3700.0)])
    rows = [dict(zip(transmission_table(result).header, r, strict=True))
            for r in transmission_table(result).rows]  # fmt: skip
    assert [row["η [%]"] for row in rows] == pytest.approx([39.2, 39.2], rel=1e-9)
    assert rows[0]["M_M [N m]"] == pytest.approx(FRICTION + 0.3 * 900.0 / GEAR / ETA)


def test_a_small_slip_has_no_efficiency_by_the_luck_of_its_starts() -> None:
    """Fx = 0 in the mean: the starts that drive must not be chosen."""
    runs = drive_runs(0.0, 0.0)
    curve = FrictionTorque(np.array([0.0, 200.0]), np.full(2, FRICTION), np.full(2, 1e-3))
    states, places = [r.state for r in runs], [r.start for r in runs]
    assert math.isnan(efficiency(states, places, curve).value)


def test_the_error_of_the_efficiency_is_linearised() -> None:
    random = np.random.default_rng(3)
    curve = FrictionTorque(np.array([0.0, 200.0]), np.full(2, FRICTION), np.full(2, 1e-3))
    found = []
    for _ in range(800):
        states = [
            DriveState(r.state.motor_torque + 0.02 * random.normal(), r.state.tire_torque, 140.0)
            for r in drive_runs(0.05, 3700.0)
        ]
        found.append(efficiency(states, UNEVEN, curve))
    spread = np.std([v.value for v in found])
    assert math.sqrt(np.mean([v.std_error**2 for v in found])) == pytest.approx(spread, rel=0.1)


def test_rolling_radii_of_the_table_and_of_the_fit_are_the_same_means() -> None:
    law = {1850.0: 0.31228, 3700.0: 0.31088, 5550.0: 0.31025}
    runs = [
        RadiusRun(slip(0.0, fz), "slip_control", r + 4e-4 * turning(s), 30.0, fz - 20.0, s)
        for fz, r in law.items()
        for s in UNEVEN
    ]
    stiffness = {slip(0.0, fz).operating_point: 1e5 for fz in law}
    values = mean_radii(runs, stiffness)
    assert [v.measured.value for v in values] == pytest.approx([*law.values()], abs=1e-12)
    assert [v.starts for v in values] == [3, 3, 3]
    (points,) = radius_points(runs, stiffness)
    wanted = [r * (1.0 + 30.0 / 1e5) for r in law.values()]
    assert points.measured["re"] == pytest.approx(wanted, abs=1e-6)
    assert points.fz == pytest.approx([fz - 20.0 for fz in law])


def test_slip_stiffness_without_a_report_is_that_of_the_mean(make_step) -> None:
    """Linear fits of single runs follow a force that turns with the wheel."""
    tables = [make_step(0.01, s, repeat=i) for i, s in enumerate(UNEVEN)]
    clean = small_slip_stiffness([step_run(t) for t in tables])
    wave = [
        t.with_columns(fx=t["fx"] + 200.0 * np.sin(
            t["wheel_angle"] + 2.0 * np.pi * (t.info.start - 1) / 3.0))
        for t in tables
    ]  # fmt: skip
    turned = small_slip_stiffness([step_run(t) for t in wave])
    assert list(turned.values()) == pytest.approx(list(clean.values()), rel=0.01)


def radius_of(source: str, radius: float, force: float) -> RadiusRun:
    return RadiusRun(slip(0.0), source, radius, force, 3700.0)


@pytest.mark.parametrize(("left", "reads"), [(0.002, "+0.2 % is left"), (0.008, "+0.8 % is left")])
def test_the_controlled_radius_is_told_against_that_of_the_free_wheel(
    left: float, reads: str
) -> None:
    """50 N drive and 44 N hold back: of one tire the free wheel has the larger radius."""
    stiffness = {slip(0.0).operating_point: 9.4e4}
    held = radius_of("controller", 0.3108 * (1.0 + left) / (1.0 + 50.0 / 9.4e4), 50.0)
    free = radius_of("flexplates_off", 0.3108 / (1.0 - 44.0 / 9.4e4), -44.0)
    text = free_wheel_text([RadiusPair(*mean_radii([held, free], stiffness))])
    assert (
        f"{100.0 * (held.radius / free.radius - 1.0):+.2g} % from that of the free wheel" in text
    )
    assert "-0.1 % by the forces of 50 and -44 N" in text
    assert reads in text
    assert "No operating point" in free_wheel_text([])


RUNS = {"run", "runs", "r", "member", "members", "table", "tables", "steps", "radii", "states"}
"""names of variables that stand for runs"""
MEANS = {"mean", "nanmean", "average", "median", "nanmedian", "fmean"}
SOURCES = Path(starts_module.__file__).parent
DOWNSTREAM = ("report", "report_files", "figures", "steady", "kinds", "identify", "post", "api")


def averages_of_runs(file: Path) -> Iterator[int]:
    """Lines in which a mean is taken over a comprehension of runs."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute | ast.Name)):
            continue
        name = node.func.attr if isinstance(node.func, ast.Attribute) else node.func.id
        inner = [n for a in node.args for n in ast.walk(a)]
        over = [g for n in inner if isinstance(n, ast.ListComp | ast.GeneratorExp)
                for g in n.generators]  # fmt: skip
        names = {n.id for g in over for part in (g.target, g.iter) for n in ast.walk(part)
                 if isinstance(n, ast.Name)}  # fmt: skip
        if name in MEANS and names & RUNS:
            yield node.lineno


def test_runs_are_averaged_by_one_function() -> None:
    found = [
        f"{file.relative_to(SOURCES)}:{line}"
        for folder in DOWNSTREAM
        for file in (SOURCES / folder).glob("**/*.py")
        for line in averages_of_runs(file)
    ]
    assert found == []


def test_the_lint_sees_other_ways(tmp_path: Path) -> None:
    file = tmp_path / "a.py"
    file.write_text(
        "a = np.mean([run.fx for run in runs])\n"
        "b = np.mean(values)\n"
        "c = float(np.mean([f(r) for r in own]))\n"
        "d = mean_over_starts([r.fx for r in runs], starts)\n"
    )
    assert list(averages_of_runs(file)) == [1, 3]
