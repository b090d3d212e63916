# SPDX-License-Identifier: Apache-2.0
"""A tire record begins every fit and report; without one it is made from the data, and said."""

from __future__ import annotations

import dataclasses
import json
import math
from pathlib import Path

import numpy as np
import pytest
from steptable import SIGMA, STIFFNESS, step_table

from flatplank_analysis.cli import fit as fit_verb
from flatplank_analysis.cli import main as command
from flatplank_analysis.cli import report as report_verb
from flatplank_analysis.models.tire_record import (
    FILE,
    PLACEHOLDER,
    parse_record,
    read_record,
    shipped_record,
)
from flatplank_analysis.report.analysis import analyse
from flatplank_analysis.report.tables import all_tables
from flatplank_analysis.report.tire import geometry_of_campaigns, made_from
from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError
from flatplank_data.exporters import export_campaign
from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable
from flatplank_tire.tir import read_tir

SLIPS = (-0.05, -0.02, 0.0, 0.02, 0.05)
LOAD, BAR = 3250.0, 2.8


def continental(folder: Path, tire: str = "CON", loads=(LOAD,)) -> Path:
    """Slip steps of a Continental at its nominal 2.8 bar, with a spring of 2.41e5 N/m below it."""
    tables = []
    for fz in loads:
        for kappa in SLIPS:
            for start in (1, 2):
                name = f"{tire}_{fz:g}_{100 * kappa:g}_{start}.parquet"
                table = step_table(kappa, start, 5.0, fz=fz, pressure=BAR, tire=tire, file=name)
                n = len(table)
                loaded = np.full(n, 0.350 - fz / 2.41e5)
                tables.append(table.with_columns(fz=np.full(n, fz), loaded_radius=loaded))
    return export_campaign(tables, folder / f"{tire}_{len(loads)}")


@pytest.fixture(scope="module")
def record(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("record") / "mine.yaml"
    path.write_text(shipped_record("continental").to_yaml(), encoding="utf-8")
    return path


@pytest.mark.parametrize("given", [True, False])
def test_the_continental_at_2_8_bar_has_a_fit_of_its_own(given, record, tmp_path, capsys):
    folder = continental(tmp_path)
    words = ["--tire", str(record)] if given else []
    assert report_verb.main([str(folder), "--jobs", "1", *words]) == 0
    page = Path(capsys.readouterr().out.strip())
    told = json.loads((page.parent / "report.json").read_text())
    fitted = read_tir(page.parent / "fitted.tir").values
    assert fitted["FNOMIN"] == LOAD and fitted["NOMPRES"] == 1e5 * BAR
    assert fitted["UNLOADED_RADIUS"] == pytest.approx(0.350, rel=0.015)
    assert fitted["PKX1"] * LOAD == pytest.approx(STIFFNESS, rel=0.05)
    assert told["mf"]["relative_errors"]["fx"] < 0.02
    assert told["tire_record"]["nominal_load"] == LOAD
    text = page.read_text(encoding="utf-8")
    assert ("made from the data" in text) is not given
    if given:
        assert "Continental EcoContact" in text


def test_fit_says_which_tire_it_is_of(record, tmp_path, capsys):
    folder = str(continental(tmp_path))
    words = [folder, "--model", "mf", "--jobs", "1"]
    assert fit_verb.main([*words, "--json", "--tire", str(record)]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["tire_record"]["free_radius"] == 0.350
    assert told["coefficients"]["FNOMIN"] == LOAD
    assert fit_verb.main(words) == 0
    assert "made from the data" in capsys.readouterr().out


def test_a_fit_without_points_is_refused_in_the_headline(tmp_path, capsys):
    folder = continental(tmp_path)
    toyo = tmp_path / "toyo.yaml"
    toyo.write_text(shipped_record("toyo").to_yaml(), encoding="utf-8")
    words = ["fit", str(folder), "--model", "mf", "--jobs", "1", "--tire", str(toyo)]
    assert command.main(words) == 1
    error = capsys.readouterr().err
    assert "no steady Fx or Fy to fit at the nominal pressure of 2.5 bar" in error
    assert "2.8 bar" in error and "--tire" in error
    assert report_verb.main([str(folder), "--jobs", "1", "--tire", str(toyo)]) == 0
    page = Path(capsys.readouterr().out.strip())
    top = page.read_text(encoding="utf-8").split("<section", 1)[0]
    assert "no Magic Formula" in top and "2.8 bar" in top
    assert not (page.parent / "fitted.tir").exists()
    assert not (page.parent / "tables" / "magic_formula.csv").exists()


def test_one_report_of_two_tires_fits_neither(tmp_path):
    one, two = (Campaign.load(continental(tmp_path, tire)) for tire in ("CON", "TOY"))
    result = analyse(one.merged(two))
    assert result.magic is None and "CON, TOY" in result.why_no_magic


def test_the_record_of_the_folder_counts(tmp_path):
    folder = continental(tmp_path)
    own = dataclasses.replace(shipped_record("continental"), mounted="2026-11-22", width=0.16)
    (folder / FILE).write_text(own.to_yaml(), encoding="utf-8")
    result = analyse(Campaign.load(folder), magic=False)
    assert result.record == dataclasses.replace(own, origin="tire.yaml of the folder")


@pytest.mark.parametrize(
    ("loads", "words", "close"),
    [((LOAD,), "placeholder", 0.015), ((1625.0, LOAD, 4875.0), "over load", 1e-4)],
)
def test_free_radius_from_the_loaded_radii(loads, words, close, tmp_path):
    found = made_from([Campaign.load(continental(tmp_path, loads=loads))])
    assert found.free_radius == pytest.approx(0.350, rel=close)
    assert (found.nominal_load, found.nominal_pressure) == (LOAD, BAR)
    assert words in found.origin


def test_free_radius_from_the_rolling_radius(tmp_path):
    table = step_table(0.0, 1)
    bare = MeasurementTable(
        {k: table[k] for k in table.columns if k != "loaded_radius"}, table.info
    )
    found = made_from([Campaign.load(export_campaign([bare], tmp_path))])
    assert found.free_radius == pytest.approx(
        table.info.effective_rolling_radius * 318 / 310.8, abs=1e-5
    )
    assert "R0 by the rolling radius, 2.3 % more as usual" in found.origin


def test_the_geometry_is_of_all_folders(tmp_path):
    """Stiffness runs at two pressures, a folder each; footprints in two, one of them alone."""
    down = np.linspace(0.35, 0.31, 300)
    radius = np.concatenate([down, down[::-1]])
    campaigns = []
    for bar, fz in ((2.5, 1850.0), (2.8, 5550.0), (None, 3700.0)):
        about = {"tire": "CON", "pressure": bar or 2.5}
        spring = 2.0e5 * (1.0 + 0.8 * (about["pressure"] / 2.5 - 1.0))
        share = fz / (spring * 0.35)
        half = 0.35 * (0.1 * share + 0.7 * np.sqrt(share))
        prints = {"fz": np.array([fz]), "half_length": np.array([half])}
        record = RunRecord(file="print.parquet", measurement="footprint", **about)
        tables = [MeasurementTable(prints, record)]
        if bar:
            columns = {"loaded_radius": radius, "fz": spring * (0.35 - radius)}
            record = RunRecord(file="press.parquet", measurement="stiffness", **about)
            tables.append(MeasurementTable(columns, record))
        campaigns.append(Campaign.load(export_campaign(tables, tmp_path / f"{fz:g}")))
    toyo = dataclasses.replace(shipped_record("toyo"), free_radius=0.35)
    for order in (campaigns, campaigns[::-1]):
        found = geometry_of_campaigns(order, toyo).contact
        assert found.vertical_stiffness == pytest.approx(2.0e5, rel=1e-3)
        assert found.pressure_effect == pytest.approx(0.8, rel=1e-2)
        assert (found.q_ra2, found.q_ra1) == pytest.approx((0.1, 0.7), rel=1e-2)


@pytest.mark.parametrize("name", ["toyo", "continental", "michelin", "racing"])
def test_shipped_records_come_back(name, tmp_path):
    record = shipped_record(name)
    path = tmp_path / "tire.yaml"
    path.write_text(record.to_yaml(), encoding="utf-8")
    again = dataclasses.replace(read_record(path), origin=record.origin)
    assert again.to_yaml() == record.to_yaml() and math.isfinite(again.width)


def test_no_tire_has_the_toyos_contact_unless_its_record_says_so():
    toyo, _ = shipped_record("toyo").geometry()
    for name in ("michelin", "racing"):
        found, sources = shipped_record(name).geometry()
        assert sources["q_ra1"] == sources["vertical_stiffness"] == PLACEHOLDER
        assert found.vertical_stiffness != toyo.vertical_stiffness


HEAD = "format: flatplank-tire/1\nname: X\n"
REST = "free_radius: 0.3\nnominal_load: 3000\nnominal_pressure: 2.5\n"
MISTAKES = [
    ("name: X\n", "begin with format: flatplank-tire/1"),
    (HEAD, "missing free_radius, nominal_load, nominal_pressure"),
    (HEAD + REST + "widht: 0.2\n", "the nearest is 'width'"),
    (
        HEAD + REST.replace("2.5", "250000"),
        "nominal_pressure is 250000 bar, must be within 0.2 .. 15",
    ),
    (HEAD + REST + "contact: {q_ra3: 1}\n", "the nearest is 'q_ra"),
    (HEAD + REST + "contact: [\n", "not YAML"),
]


@pytest.mark.parametrize(("text", "words"), MISTAKES)
def test_mistakes_in_a_record_are_one_line(text, words):
    with pytest.raises(FlatplankError) as caught:
        parse_record(text, "mine.yaml")
    assert words in str(caught.value) and "\n" not in str(caught.value)
    assert "mine.yaml" in str(caught.value)


def test_one_operating_point_gives_c_x_and_the_page_says_so(tmp_path):
    """With the thesis's 162 kN/m in the place of its own the error at 2 % is ten times larger."""
    result = analyse(Campaign.load(continental(tmp_path)), tire=shipped_record("continental"))
    own = result.points[0].carcass
    found = result.magic.tir.coefficients.LONGITUDINAL_STIFFNESS
    assert found == pytest.approx(own.slip_stiffness.value / own.sigma_x.value, rel=1e-6)
    assert found == pytest.approx(STIFFNESS / SIGMA, rel=0.1)
    assert "1 operating point" in result.magic.cx_source
    small = [v for c, v in result.points[0].models["mf"].rmse.items() if abs(c.kappa) == 0.02]
    assert max(small) < 20.0
    shown = {t.name: t for t in all_tables(result)}["model_parameters"]
    assert all("Toyo" not in str(cell) for row in shown.rows for cell in row)
