# SPDX-License-Identifier: Apache-2.0
"""Runs at +alpha and -alpha tell the steering zero, ply steer and the cornering stiffness."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from plant_tires import plant_campaign

from flatplank_analysis.cli import fit as fit_verb
from flatplank_analysis.identify.lateral import fit_lateral_carcass, lateral_run
from flatplank_analysis.models.tire_record import shipped_record
from flatplank_analysis.report.analysis import analyse
from flatplank_analysis.report.tables import all_tables
from flatplank_data.campaign import Campaign
from flatplank_sim.plant.config import PlantConfig
from flatplank_validation.truth import truth_row

ANGLES = (-10.0, -5.0, -1.0, 0.0, 1.0, 5.0, 10.0)
ZERO, PLY = -0.015, 0.003
GEOMETRY, _ = shipped_record("toyo").geometry()


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    defects = {"steering_zero_error": {"angle": ZERO}, "ply_steer": {"angle": PLY}}
    folder = tmp_path_factory.mktemp("zero") / "toyo"
    plant_campaign(folder, "toyo", (-0.02, 0.02), ANGLES, defects=defects)
    return [lateral_run(table) for table in Campaign.load(folder).tables()]


@pytest.fixture(scope="module")
def stiffness() -> float:
    return truth_row(PlantConfig.load("toyo"), 3700.0, 2.5).cornering_stiffness


def fitted(runs) -> dict:
    fit = fit_lateral_carcass(runs, geometry=GEOMETRY)
    return {e.name: e for e in fit.estimates}


def test_zero_and_ply_steer_are_told_apart(runs, stiffness):
    found = fitted(runs)
    for name, true in (("steering_zero", ZERO), ("ply_steer", PLY)):
        low, high = found[name].interval()
        assert low <= math.degrees(true) <= high, name
        assert high - low < 0.4
    assert found["cornering_stiffness"].value == pytest.approx(stiffness, rel=0.03)
    assert not found["cornering_stiffness"].note


def test_without_slip_steps_only_their_sum_is_known(runs, stiffness):
    found = fitted([replace(run, slip_stiffness=math.nan) for run in runs])
    zero = found["steering_zero"]
    low, high = zero.interval()
    assert low <= math.degrees(ZERO + PLY) <= high and "with ply steer" in zero.note
    assert not found["ply_steer"].determined
    assert found["cornering_stiffness"].value == pytest.approx(stiffness, rel=0.03)


def test_one_sign_of_the_angle_is_warned_of(runs):
    found = fitted([run for run in runs if run.level >= 0.0])
    assert "steering_zero" not in found
    assert "a steering zero error is in it" in found["cornering_stiffness"].note
    assert "both signs" in found["cornering_stiffness"].note
    assert found["c_cy"].note == found["cornering_stiffness"].note


WARNING = "a steering zero error is in it: add runs at 2 angles with both signs"


@pytest.fixture(scope="module", params=[(0.0, 2.0, 5.0), (-5.0, -2.0, 0.0, 2.0, 5.0)])
def folder(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("signs") / "toyo"
    defects = {"steering_zero_error": {"angle": ZERO}}
    plant_campaign(folder, "toyo", (-0.02, 0.0, 0.02), request.param, (1, 2), defects)
    return folder, len(request.param) == 3


def test_the_warning_stands_beside_the_number_wherever_it_is_printed(folder, capsys):
    path, one_sided = folder
    words = [str(path), "--jobs", "1"]
    beside = {"lateral": ("c_cy", "cornering_stiffness"), "mf": ("PKY1", "PHY1", "PVY1", "QHZ1")}
    for model, names in beside.items():
        capsys.readouterr()
        assert fit_verb.main([*words, "--model", model]) == 0
        lines = [line for line in capsys.readouterr().out.splitlines() if line]
        for name in names:
            (line,) = [li for li in lines if name in li.split("  ") and not li.startswith("note")]
            assert (WARNING in line) == one_sided, line
            assert name != "c_cy" or "own bias" in line
    assert fit_verb.main([*words, "--model", "lateral", "--json"]) == 0
    assert (WARNING in capsys.readouterr().out) == one_sided
    tables = {t.name: t for t in all_tables(analyse(Campaign.load(path)))}
    rows = [
        dict(zip(tables["lateral"].header, row, strict=True)) for row in tables["lateral"].rows
    ]
    assert rows and all((WARNING in row["remark"]) == one_sided for row in rows)
