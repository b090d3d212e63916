# SPDX-License-Identifier: Apache-2.0
"""A tire file from the sweeps of other benches, whose tires share no formula with the models."""

from __future__ import annotations

import io
import json
from contextlib import redirect_stdout

import bench_of_sweeps as bench
import formula_of_sweeps as tire
import numpy as np
import pytest

import flatplank_analysis as fp
from flatplank_analysis.cli.main import main
from flatplank_analysis.identify.mf.fit import FitFile, fit_magic_formula
from flatplank_analysis.identify.mf.information import reach_of
from flatplank_analysis.identify.mf.points import steady_points
from flatplank_analysis.identify.mf.stages import general_start
from flatplank_analysis.models.tire_record import TireRecord, start_tir
from flatplank_analysis.slip_sweeps.fit import fit_sweeps, points_of
from flatplank_analysis.slip_sweeps.study import study
from flatplank_tire.errors import FlatplankError
from flatplank_tire.magic_formula import DEFAULTS, steady_forces
from flatplank_tire.tir import read_tir, shipped_tir, write_tir


@pytest.fixture(scope="module")
def brush(tmp_path_factory):
    """Sweeps of the slip angle at one pressure, upright."""
    columns = bench.recording(cambers=(0.0,), pressures=(83.0,))
    return bench.write_mat(tmp_path_factory.mktemp("brush") / "side.mat", columns)


@pytest.fixture(scope="module")
def told(brush, tmp_path_factory):
    """What `flatplank sweeps --fit --json` says, and the file that it writes."""
    out = tmp_path_factory.mktemp("fit") / "out.tir"
    with redirect_stdout(io.StringIO()) as said:
        assert main(["sweeps", str(brush), "--fit", str(out), "--json"]) == 0
    return json.loads(said.getvalue()), out


def test_the_fitted_file_fails_nowhere(brush, told):
    assert_fails_nowhere(study(brush), read_tir(told[1]))


def assert_fails_nowhere(found, tir):
    for failure, curve in zip(found.failures(tir), found.curves, strict=True):
        assert failure.error < curve.floor and failure.share < 0.015


def test_slip_and_slip_angle_in_two_files_give_one_tire(tmp_path):
    def two_loads(swept):
        columns = bench.recording(swept, cambers=(0.0,), pressures=(83.0,))
        light = columns["fz"] < 1000.0
        light = {k: v[light] for k, v in columns.items()}
        return study(bench.write_mat(tmp_path / f"{swept}.mat", light))

    side, along = two_loads("alpha"), two_loads("kappa")
    found = fit_sweeps([side, along])
    assert not found.held_out and set(found.fit.fits) >= {"fx", "fy"}
    assert_fails_nowhere(side, found.file)
    assert_fails_nowhere(along, found.file)


def test_a_load_that_the_fit_has_not_seen_is_predicted(told):
    held_out = [h for h in told[0]["fit"]["held_out"] if h["force"] == "fy"]
    assert [(h["force"], round(h["load"], -2)) for h in held_out] == [
        ("fy", 400), ("fy", 800), ("fy", 1200)
    ]  # fmt: skip
    for h in held_out:
        truth = bench.brush(bench.triangle(0.2, 200), np.full(200, h["load"]))
        assert h["r_squared"] == pytest.approx(1.0 - (h["error"] / np.std(truth)) ** 2, abs=0.01)
        assert h["r_squared"] > 0.99


def test_what_sweeps_do_not_measure_keeps_its_default_and_says_so(told):
    text, values = told[1].read_text(), read_tir(told[1]).values
    for name in ("RBX1", "RBY1", "PDY3", "PPY1"):
        assert values[name] == DEFAULTS[name], name
    (line,) = (line for line in text.splitlines() if line.startswith("UNLOADED_RADIUS"))
    assert "not measured by sweeps" in line
    assert values["FNOMIN"] == pytest.approx(800.0, rel=0.01)
    assert values["NOMPRES"] == pytest.approx(83e3)


def test_the_next_sweep_is_one_of_this_tire(brush):
    points = points_of([study(brush)])
    reach = reach_of(points)
    assert max(reach["fz"]) == pytest.approx(1800.0, rel=0.05)
    assert max(reach["pressure"]) == pytest.approx(1.25e5, rel=0.05)


def test_the_formula_behind_the_sweeps_is_found(tmp_path):
    """Relative to a formula written from the book, within what the noise allows."""
    slip = 12.0 * np.sin(np.linspace(0.0, 2.0 * np.pi, 480))
    path = tire.files(tmp_path, tire.text_of(tire.sweep(slip, (0.0, 4.0))))[0]
    found = fp.sweeps(path).fit()
    assert found.remarks["NOMPRES"] == "not in the sweeps: a placeholder"
    coefficients = found.file.coefficients
    alpha = np.radians(np.linspace(-11.0, 11.0, 23))
    for fz in tire.LOADS:
        for gamma in np.radians((0.0, 4.0)):
            truth = tire.side_force(fz, alpha, gamma)
            fy = steady_forces(coefficients, fz, alpha=alpha, gamma=gamma, vx=10.0)[1]
            assert fy == pytest.approx(truth, abs=2.0 * tire.NOISE)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--tir", "a.tir", "--fit", "b.tir"], "--fit and --tir"),
        (["--radius", "0.3"], "give --fit OUT.tir"),
        (["--fit", "b.tir", "--radius", "26"], "give the free radius in m"),
    ],
)
def test_options_that_contradict_each_other(brush, words, said, capsys):
    assert main(["sweeps", str(brush), *words]) != 0
    assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    ("version", "fittyp", "law", "foreign"),
    [("5.2", "6", "5.2", "PKY6"), ("6.1", "61", "6.1", "PHY3"), ("6.2", "62", "6.1", "PHY3")],
)
def test_a_fit_has_the_version_that_was_asked_for(version, fittyp, law, foreign, tmp_path):
    columns = bench.recording(cambers=(0.0, 4.0), pressures=(83.0,))
    one = study(bench.write_mat(tmp_path / "side.mat", columns))
    found = fit_sweeps([one], version=version)
    write_tir(found.file, tmp_path / "out.tir")
    back = read_tir(tmp_path / "out.tir")
    assert back.entries["FITTYP"].value == fittyp and back.law == law
    assert foreign not in back.entries and foreign not in found.fit.estimates
    assert {"PKY1", "PVY3"} <= set(found.fit.estimates)
    assert back.values == found.file.values  # the file read is the file written
    for failure in one.failures(back):
        assert failure.share < 0.03


def test_a_fit_of_5_2_finds_the_formula_of_5_2(tmp_path):
    """Fy of the book's older equations, 4.E19 to 4.E30 with Sh = PHY3 gamma (Pacejka 2006)."""
    true = {"PCY1": 1.3, "PDY1": 1.1, "PDY2": -0.15, "PEY1": -0.5, "PKY1": -18.0, "PKY2": 1.8,
            "PHY3": 0.04, "PVY3": -0.3}  # fmt: skip
    grid = np.meshgrid(np.radians(np.linspace(-12, 12, 25)), [2e3, 4e3, 6e3], [0.0, 0.07])
    alpha, fz, gamma = (v.ravel() for v in grid)
    load = fz / 4e3
    d = (true["PDY1"] + true["PDY2"] * (load - 1.0)) * fz
    k = true["PKY1"] * 4e3 * np.sin(2.0 * np.arctan(load / true["PKY2"]))
    b, x = k / (true["PCY1"] * d), alpha + true["PHY3"] * gamma
    inner = b * x - true["PEY1"] * (b * x - np.arctan(b * x))
    fy = d * np.sin(true["PCY1"] * np.arctan(inner)) + true["PVY3"] * gamma * fz
    nan = np.full(len(fy), np.nan)
    points = steady_points(
        {"fx": nan, "fy": fy, "mz": nan}, fz=fz, kappa=0.0 * fz, alpha=alpha, gamma=gamma,
        pressure=np.full(len(fy), 2e5),
    )  # fmt: skip
    record = TireRecord("closed form", 0.3, 4000.0, 2.0)
    start = start_tir(record, general_start()).of_version("5.2")
    fit = fit_magic_formula(points, start, FitFile(stages=("pure_y", "camber")))
    for name, value in true.items():
        assert fit.tir.values[name] == pytest.approx(value, rel=0.01, abs=1e-3), name


def test_a_start_of_another_version_is_refused(brush, tmp_path):
    with pytest.raises(FlatplankError, match=r"is of Magic Formula 6.1, the fit of 5.2"):
        fit_sweeps([study(brush)], shipped_tir(), version="5.2")
    with pytest.raises(FlatplankError, match=r"known: 5.2, 6.1, 6.2"):
        fit_sweeps([study(brush)], version="7")
