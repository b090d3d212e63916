# SPDX-License-Identifier: Apache-2.0
"""The aligning moment of a tire file from sweeps: a formula written from the book, and a brush."""

from __future__ import annotations

import json

import formula_of_sweeps as tire
import numpy as np
import pytest

import flatplank_analysis as fp
from flatplank_analysis.cli.main import main
from flatplank_analysis.identify.mf.points import steady_points
from flatplank_analysis.slip_sweeps.further import further
from flatplank_analysis.slip_sweeps.moment import AHEAD, EMPTY
from flatplank_tire.magic_formula import DEFAULTS, steady_forces
from flatplank_tire.tir import read_tir
from flatplank_validation.sweep_sets.brush import Brush, Plan, sweeps, text_of

NONE_OF_LOAD = ("QBZ2", "QDZ2", "QEZ2", "QHZ2", "QDZ7")
"""how the moment follows the load"""


def written(folder, columns, name="side.csv"):
    path = folder / name
    path.write_text(tire.text_of(columns))
    return path


@pytest.fixture(scope="module")
def leaning(tmp_path_factory):
    """The fit to sweeps of the formula at three cambers."""
    columns = tire.sweep(tire.wave(480), (-4.0, 0.0, 4.0))
    return fp.sweeps(written(tmp_path_factory.mktemp("leaning"), columns)).fit(radius=tire.RADIUS)


def test_the_moment_of_the_formula_is_found_at_every_load_and_camber(leaning):
    c, alpha = leaning.file.coefficients, np.radians(np.linspace(-11.0, 11.0, 23))
    for fz in tire.LOADS:
        for gamma in np.radians((-4.0, 0.0, 4.0)):
            mz = steady_forces(c, fz, alpha=alpha, gamma=gamma, vx=10.0)[2]
            assert mz == pytest.approx(tire.moment(fz, alpha, gamma), abs=tire.MOMENT_NOISE)


def test_its_coefficients_are_found_within_their_intervals(leaning):
    """The file has another nominal load, so the coefficients over the load are others."""
    estimates = leaning.fit.estimates
    more = leaning.file.values["FNOMIN"] / tire.NOMINAL - 1.0
    truth = {name: tire.Q[name] for name in ("QCZ1", "QHZ1", "QDZ3", "QBZ9")}
    truth |= {
        f"{name}1": tire.Q[f"{name}1"] + more * tire.Q[f"{name}2"] for name in ("QBZ", "QEZ")
    }
    truth["QDZ8"] = tire.Q["QDZ8"] + more * tire.Q["QDZ9"]
    truth["QDZ1"] = (tire.Q["QDZ1"] + more * tire.Q["QDZ2"]) * (1.0 + more)
    for name, value in truth.items():
        one = estimates[name]
        # 1.96 standard errors would miss one of these eight in a third of all sweeps
        assert one.value == pytest.approx(value, abs=4.0 * one.std_error, rel=0.01), name


def test_each_load_left_out_is_predicted_with_its_moment(leaning):
    moments = [h for h in leaning.held_out if h.force == "mz"]
    assert [round(h.load) for h in moments] == list(tire.LOADS)
    assert all(h.r_squared > 0.999 for h in moments)


def test_the_trail_of_a_brush_is_found_without_its_formula(tmp_path):
    """The law of the trail is flat at no slip, the trail of a brush has a corner there: what is
    left is the law's."""
    path = tmp_path / "brush.csv"
    brush = Brush()
    path.write_text(text_of(sweeps(brush, Plan(), 3)), encoding="utf-8")
    found = fp.sweeps(path)
    fit = found.fit(radius=0.31)
    for failure in found.studies[0].moment_failures(fit.file).values():
        assert failure.share < 0.07
    assert all(h.r_squared > 0.9 for h in fit.held_out)
    fz, small = brush.nominal, np.radians(0.8)
    _, fy, mz = steady_forces(fit.file.coefficients, fz, alpha=small, vx=10.0)
    # at no slip a third of the half length, less with each bristle that slides
    assert 0.6 < -mz / fy / (brush.half_length / 3.0) < 1.0


def test_the_signs_of_the_file_do_not_change_the_tire(tmp_path):
    columns = tire.sweep(tire.wave(480))
    turned = {k: -v if k in ("SA", "FY", "FZ", "MZ") else v for k, v in columns.items()}
    one, other = (
        fp.sweeps(written(tmp_path, c, f"{k}.csv")).fit().file.values
        for k, c in enumerate((columns, turned))
    )
    assert one["QDZ1"] > 0.0
    assert {k: other[k] for k in one} == pytest.approx(one, rel=1e-3, abs=1e-3)


@pytest.mark.parametrize(
    ("moment", "line"), [(lambda c: -c["MZ"], AHEAD), (lambda c: 0.0 * c["MZ"], EMPTY)]
)
def test_a_moment_that_cannot_be_one_is_left_out_with_a_line(moment, line, tmp_path):
    columns = tire.sweep(tire.wave(240))
    path = written(tmp_path, columns | {"MZ": moment(columns)})
    found = fp.sweeps(path)
    assert line in found.studies[0].said and not found.studies[0].moments
    assert "mz" not in found.fit().fit.fits
    if line is AHEAD:
        assert len(fp.sweeps(path, turn=["mz"]).studies[0].moments) == len(tire.LOADS)


def test_sweeps_without_a_moment_make_a_file_without_one(tmp_path, capsys):
    columns = tire.sweep(tire.wave(240))
    del columns["MZ"]
    path, out = written(tmp_path, columns), tmp_path / "out.tir"
    assert main(["sweeps", str(path), "--fit", str(out)]) == 0
    assert "Mz" not in capsys.readouterr().out.partition("for Fx you still need")[0]
    values = read_tir(out).values
    for name in DEFAULTS:
        if name.startswith("Q") and name[2] == "Z":
            assert values.get(name, 0.0) == DEFAULTS[name], name


def test_one_load_keeps_what_the_load_would_tell_at_its_default(tmp_path):
    columns = tire.sweep(tire.wave(480))
    one = columns["FZ"] == tire.LOADS[1]
    columns = {k: v[one] for k, v in columns.items()} | {"ET": columns["ET"][: one.sum()]}
    out = tmp_path / "out.tir"
    found = fp.sweeps(written(tmp_path, columns)).fit(radius=tire.RADIUS)
    found.save(out)
    assert not found.held_out and "QBZ10" not in found.fit.estimates
    lines = {line.split()[0]: line for line in out.read_text().splitlines() if line.split()}
    for name in NONE_OF_LOAD:
        assert read_tir(out).values[name] == pytest.approx(0.0, abs=1e-9), name
        assert "not determined" in lines[name], name
    alpha = np.radians(np.linspace(-11.0, 11.0, 23))
    mz = steady_forces(found.file.coefficients, tire.LOADS[1], alpha=alpha, vx=10.0)[2]
    assert mz == pytest.approx(tire.moment(tire.LOADS[1], alpha, 0.0), abs=tire.MOMENT_NOISE)


def test_the_exact_file_fails_nowhere_and_its_errors_are_told_in_newton_metres(tmp_path, capsys):
    path, exact = tire.files(tmp_path, tire.text_of(tire.sweep(tire.wave(240), (0.0, 4.0))))
    assert main(["sweeps", str(path), "--tir", str(exact)]) == 0
    told = capsys.readouterr().out
    assert "error [Nm]" in told and "fails in Mz in 0 of 6 conditions" in told
    assert main(["sweeps", str(path), "--tir", str(exact), "--json"]) == 0
    conditions = json.loads(capsys.readouterr().out)["conditions"]
    assert all(c["mz"]["error"] < tire.MOMENT_NOISE for c in conditions)
    table = fp.sweeps(path).compare(exact)
    assert table["mz.error"].max() == pytest.approx(max(c["mz"]["error"] for c in conditions))
    figure = fp.sweeps(path).plot(exact)
    assert [p.get_ylabel() for p in figure.axes] == ["Fy [N]"] * 6 + ["Mz [Nm]"] * 6


@pytest.mark.parametrize(
    ("levels", "more"),
    [
        ({}, set()),
        ({"fz": 2}, {"QBZ10"}),
        ({"fz": 3}, {"QBZ10"}),
        ({"fz": 4}, {"QBZ10", "QBZ3", "QEZ3"}),
        ({"gamma": (-0.1, 0.1)}, set()),
        ({"gamma": (-0.1, 0.0, 0.1)}, {"QBZ4", "QEZ5"}),
        ({"gamma": (0.0, 0.05, 0.1)}, {"QBZ4", "QEZ5", "QDZ10"}),
        ({"gamma": (0.0, 0.1), "fz": 2}, {"QBZ10", "QHZ4"}),
        ({"gamma": (0.0, 0.1), "pressure": 2}, {"PPZ2"}),
    ],
)
def test_a_further_coefficient_needs_the_levels_that_tell_it(levels, more):
    usual = {"fz": 1, "pressure": 1, "gamma": (0.0,)} | levels
    axes = {
        "fz": 1000.0 * np.arange(1, usual["fz"] + 1), "alpha": np.radians(np.linspace(-9, 9, 19)),
        "pressure": 1e5 * np.arange(2, 2 + usual["pressure"]), "gamma": np.array(usual["gamma"]),
    }  # fmt: skip
    grid = dict(zip(axes, (g.ravel() for g in np.meshgrid(*axes.values())), strict=True))
    points = steady_points({"mz": grid["alpha"]}, **grid)
    assert set(further(points, "6.1")) == more | {"QBZ9", "QEZ4"}
    assert not further(steady_points({"fy": grid["alpha"]}, **grid), "6.1")
    assert "PPZ2" not in further(points, "5.2") and "QDZ10" not in further(points, "5.2")
