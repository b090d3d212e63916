# SPDX-License-Identifier: Apache-2.0
"""Drive torque, stiffness at rest, lateral transients and sources of r_e in the report."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from steptable import step_table

from flatplank_analysis.cli import fit as cli_fit
from flatplank_analysis.cli import report as cli_report
from flatplank_analysis.identify.mf.fit import FitFile, fit_magic_formula
from flatplank_analysis.identify.mf.points import merge
from flatplank_analysis.report.analysis import analyse
from flatplank_analysis.report.machine_tables import MACHINE_TABLES
from flatplank_analysis.report.steps import extras_as_points
from flatplank_analysis.report.tables import all_tables
from flatplank_analysis.report_files.build import make_figures
from flatplank_data.campaign import Campaign
from flatplank_data.exporters import export_campaign
from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable
from flatplank_tire.tir import shipped_tir

SIGMA_Y, STIFFNESS_Y = 0.35, 6.0e4
ETA, STATIC, SIDE = 0.392, 1.0e5, 0.9e5
ALPHA = 5.0
HELD = 0.008


def _run(kappa: float, start: int, alpha: float) -> MeasurementTable:
    name = f"TOY_REL_{100 * kappa:g}perc_a{alpha:g}_{start}.parquet"
    table = step_table(kappa, start, 3.0, alpha_deg=alpha, file=name)
    x = table["plank_position"]
    tangent = math.tan(math.radians(alpha))
    travel = x * math.cos(math.radians(alpha))
    side = -STIFFNESS_Y * tangent * -np.expm1(-travel / SIGMA_Y)
    tire = np.maximum(table["fx"], 0.0) * 0.3 / 1425.04
    motor = 1.5 + 0.002 * table["motor_velocity"] + tire / ETA
    # the wheel is held for 8 mm, and the standing tire is wound up
    held = x < HELD
    angle = table["wheel_angle"] - np.interp(HELD, x, table["wheel_angle"])
    fx = np.where(held, -STATIC * x, table["fx"])
    return table.with_columns(
        fy=side, motor_torque=motor, fx=fx, wheel_angle=np.where(held, 0.0, angle)
    )


def _standing(alpha: float) -> MeasurementTable:
    """The road creeps under the held wheel; the spring is STATIC along and SIDE across."""
    x = np.linspace(0.0, 0.012, 400)
    along, across = x * math.cos(math.radians(alpha)), x * math.sin(math.radians(alpha))
    kind = "stiffness_lateral" if alpha else "stiffness_longitudinal"
    info = RunRecord(
        file=f"{kind}.parquet", tire="TOY", measurement=kind, fz=3700.0, pressure=2.5,
        alpha_deg=alpha,
    )  # fmt: skip
    columns = {"plank_position": x, "fx": -STATIC * along, "fy": -SIDE * across}
    return MeasurementTable(
        columns | {"wheel_angle": np.zeros(400), "fz": np.full(400, 3700.0)}, info
    )


def _loading(bar: float) -> MeasurementTable:
    """A standing tire of r_0 = 0.32 m, stiffer by half of the pressure's change."""
    radius = 0.32 - 0.04 * np.concatenate([np.linspace(0.0, 1.0, 200), np.linspace(1.0, 0.0, 200)])
    stiffness = 2.0e5 * (1.0 + 0.5 * (bar / 2.5 - 1.0))
    info = RunRecord(
        file=f"load_{bar:g}.parquet", tire="TOY", measurement="stiffness_vertical", pressure=bar
    )
    return MeasurementTable({"loaded_radius": radius, "fz": stiffness * (0.32 - radius)}, info)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    tables = [_run(k, s, a) for a in (0.0, ALPHA) for k in (-0.02, 0.0, 0.02) for s in (1, 2, 3)]
    rolling = step_table(0.0, 1, measurement="free_rolling", file="TOY_ERR_1.parquet")
    # at +50 N the tire slips by 50 N over C_Fk: the wheel turns faster
    faster = 1.0 + 50.0 / 9e4
    tables.append(
        rolling.with_columns(
            fx=np.full(len(rolling), 50.0), motor_velocity=rolling["motor_velocity"] * faster
        )
    )
    speed = np.repeat(np.linspace(0.0, 200.0, 21), 20)
    turn = {
        "time": 0.05 * np.arange(speed.size), "motor_velocity": speed,
        "motor_torque": 1.5 + 0.002 * speed,
    }  # fmt: skip
    info = RunRecord(file="turn.parquet", tire="TOY", measurement="unloaded_turn")
    tables.append(MeasurementTable(turn, info))
    load, b = np.array([1850.0, 3700.0, 5550.0]), np.array([0.062, 0.073, 0.079])
    prints = {"fz": load, "half_length": np.array([0.0496, 0.0708, 0.0872]), "half_width": b}
    info = RunRecord(file="print.parquet", tire="TOY", measurement="footprint", pressure=2.5)
    tables.append(MeasurementTable(prints, info))
    tables += [_standing(0.0), _standing(40.0), *(_loading(p) for p in (2.0, 2.5))]
    return export_campaign(tables, tmp_path_factory.mktemp("beside") / "campaign")


@pytest.fixture(scope="module")
def result(folder):
    return analyse(Campaign.load(folder), magic=False)


@pytest.fixture(scope="module")
def tables(result):
    return {t.name: t for t in all_tables(result)}


def column(table, name: str) -> list:
    place = list(table.header).index(name)
    return [row[place] for row in table.rows]


def test_all_of_them_are_there(tables, result):
    assert {make(result).name for make in MACHINE_TABLES} <= set(tables)
    names = {f.name for group in make_figures(result).values() for f in group}
    assert {"transmission", "lateral_start", "friction_torque"} <= names


def test_efficiency_of_driving_runs_only(tables):
    table = tables["transmission"]
    found = dict(zip(column(table, "κ [%]"), column(table, "η [%]"), strict=True))
    assert found["2"] == pytest.approx(100.0 * ETA, rel=0.02)
    assert math.isnan(found["-2"])


def test_stiffness_at_rest(tables):
    assert column(tables["longitudinal_stiffness"], "C_x at rest [kN/m]") == pytest.approx(
        [1e-3 * STATIC] * 2, rel=0.02
    )


def test_standing_tire(tables):
    rows = {row[3]: row for row in tables["standing"].rows}
    assert rows["C_x"][4] == pytest.approx(1e-3 * STATIC, rel=0.01)
    assert rows["C_y"][4] == pytest.approx(1e-3 * SIDE, rel=0.01)


def test_table_7_2_says_where_its_numbers_come_from(tables):
    rows = {row[0]: row for row in tables["model_parameters"].rows}
    assert rows["C_z0"][1] == pytest.approx(2.0e5, rel=1e-3)
    assert rows["p_Fz1"][1] == pytest.approx(0.5, rel=1e-3)
    assert rows["C_z0"][3] == "measured in this campaign"
    assert rows["q_ra1"][3] == "measured in this campaign"
    assert rows["m_c"][3].startswith("not fitted")


def test_vertical_stiffness_in_the_tire_has_the_free_radius_of_its_own_runs(result):
    points = merge(extras_as_points(result.extras, (), ()))
    found = fit_magic_formula(points, shipped_tir(), FitFile(stages=("stiffness",)))
    stiffness = found.estimates["VERTICAL_STIFFNESS"]
    assert stiffness.value == pytest.approx(2.0e5, rel=1e-3)
    assert found.estimates["PFZ1"].value == pytest.approx(0.5, rel=1e-3)
    assert {"Q_RA1", "Q_RA2", "Q_RB1", "Q_RB2"} <= set(found.estimates)
    # two runs for two coefficients: nothing is left that could tell their error
    assert math.isnan(stiffness.std_error) and "no error without repeats" in stiffness.note
    told = found.estimates["LATERAL_STIFFNESS"]
    assert math.isnan(told.std_error)  # one run tells the value, and nothing of its slope
    assert any("PCFY2" in text and "not determined by 1 load" in text for text in found.skipped)


def test_lateral_relaxation_from_the_start_of_rolling(tables):
    (row,) = tables["lateral"].rows
    assert row[2] == "5"
    assert column(tables["lateral"], "σy [m]") == pytest.approx([SIGMA_Y], rel=0.02)
    assert column(tables["lateral"], "C′Fα [kN/rad]") == pytest.approx(
        [1e-3 * STIFFNESS_Y], rel=0.01
    )
    assert column(tables["lateral"], "Fy,ss [N]")[0] < 0.0


def test_the_force_explains_the_radius_of_the_controller(tables):
    table = tables["radius_sources"]
    (reading,) = column(table, "reading")
    assert reading == "the force explains it"
    share = column(table, "by the force [%]")[0]
    assert share == pytest.approx(column(table, "difference [%]")[0], rel=0.1)
    assert abs(share) == pytest.approx(100.0 * 50.0 / 9e4, rel=0.1)


def test_verb_fit_in_y(tmp_path, capsys):
    angles = (0.0, 2.0, 5.0)
    tables = [_run(0.02, start, alpha) for alpha in angles for start in (1, 2)]
    folder = export_campaign(tables, tmp_path / "side")
    assert cli_fit.main([str(folder), "--model", "lateral", "--jobs", "1", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    (fit,) = found["conditions"]
    assert fit["condition"]["alpha_deg"] is None and fit["condition"]["fz"] == 3700.0
    assert fit["sigma_y"]["value"] == pytest.approx(SIGMA_Y, rel=0.1)
    assert fit["cornering_stiffness"]["value"] == pytest.approx(STIFFNESS_Y, rel=0.02)
    assert fit["c_cy"]["determined"] and fit["c_cy"]["unit"] == "N/m"
    assert found["geometry"]["q_ra1"]["source"].startswith("not measured")
    assert cli_fit.main([str(folder), "--model", "lateral", "--jobs", "1"]) == 0
    assert "sigma_y" in capsys.readouterr().out


def test_one_report_of_two_folders(folder, tmp_path, capsys):
    other = export_campaign(
        [step_table(0.05, s, 3.0, file=f"more_{s}.parquet") for s in (1, 2, 3)], tmp_path / "more"
    )
    out = tmp_path / "out"
    folders = [str(folder), str(other)]
    assert cli_report.main([*folders, "--out", str(out), "--jobs", "1"]) == 0
    assert "report.html" in capsys.readouterr().out
    assert "+5 %" in (out / "tables" / "rmse_linear.csv").read_text()
