# SPDX-License-Identifier: Apache-2.0
"""Sweeps of another bench: axes and units are found and said, a wrong tire file is told where."""

from __future__ import annotations

import json
from pathlib import Path

import bench_of_sweeps as bench
import formula_of_sweeps as tire
import numpy as np
import pytest

import flatplank_analysis as fp
from flatplank_analysis.cli.main import main
from flatplank_analysis.slip_sweeps.study import study
from flatplank_analysis.slip_sweeps.verdict import RISK
from flatplank_data.errors import FlatplankError
from flatplank_tire.magic_formula import steady_forces
from flatplank_tire.tir import TIRE_FILES, read_tir

SHIPPED = TIRE_FILES / "toyo_nanoenergy.tir"
WRITERS = {
    "mat": (bench.write_mat, bench.SAE, "SAE J670"),
    "dat": (bench.write_dat, bench.SAE, "SAE J670"),
    "csv": (bench.write_csv, (), "ISO W"),
    "adapted.csv": (bench.write_csv, bench.ADAPTED, "adapted SAE"),
}


@pytest.mark.parametrize("kind", WRITERS)
def test_the_same_sweeps_in_any_file_and_axes(kind, tmp_path):
    write, turned, title = WRITERS[kind]
    columns = bench.recording()
    found = study(write(tmp_path / f"a.{kind}", columns, turned))
    assert found.said[0].startswith(f"axes: {title}")
    for name in ("alpha", "fy", "fz", "mz", "gamma", "pressure"):
        size = np.abs(columns[name]).max()
        assert found.columns[name] == pytest.approx(columns[name], abs=1e-4 * size), name
    warm = columns["TSTC"] + 273.15
    assert found.columns["temperature"] == pytest.approx(warm, rel=1e-3) and not found.further
    levels = {
        (round(c.held["fz"], -2), round(np.degrees(c.held["gamma"])), round(c.held["pressure"]))
        for c in found.conditions
    }
    wanted = {(f, g, 1e3 * p) for f in bench.LOADS for g in bench.CAMBERS for p in bench.PRESSURES}
    assert levels == wanted and len(found.conditions) == len(wanted)


def test_units_that_a_file_does_not_say_are_said(tmp_path):
    said = study(bench.write_csv(tmp_path / "a.csv", bench.recording())).said
    (line,) = (line for line in said if line.startswith("no unit in the file, taken to be: "))
    for words in ("alpha in deg (up to 11.", "pressure in kPa (", "fz in N (", "kappa in - (",
                  "mz in Nm (", "time in s (", "speed in km/h ("):  # fmt: skip
        assert words in line
    with_units = study(bench.write_mat(tmp_path / "a.mat", bench.recording())).said
    assert len(with_units) == 1


def test_stiffness_and_peak_of_the_curves_are_those_of_the_tire(tmp_path):
    found = study(bench.write_mat(tmp_path / "a.mat", bench.recording()))
    for condition, formula in zip(found.conditions, found.formulas, strict=True):
        fz = condition.held["fz"]
        stiffness = bench.STIFFNESS * (1.0 - bench.SOFTENS * fz) * fz
        peak = bench.GRIP * (1.0 - bench.TIRES * fz) * fz
        assert formula.stiffness == pytest.approx(-stiffness, rel=0.15)
        assert formula.values["D"] == pytest.approx(-peak, rel=0.05)


def test_a_sweep_that_stays_small_does_not_say_the_peak(tmp_path, capsys):
    columns = bench.recording(cambers=(0.0,), pressures=(83.0,))
    for name in ("alpha", "fy", "mz"):
        columns[name] = columns[name] * 0.25
    columns["fy"] = -bench.brush(columns["alpha"], columns["fz"]) + np.random.default_rng(
        1
    ).normal(0.0, 12.0, len(columns["fz"]))
    found = study(bench.write_mat(tmp_path / "a.mat", columns))
    assert found.formulas and not any(f.known("D") for f in found.formulas if f)
    assert main(["sweeps", str(tmp_path / "a.mat")]) == 0
    rows = [r for r in capsys.readouterr().out.splitlines() if "slip angle" in r and "(" in r]
    assert len(rows) >= len(found.conditions)


def test_the_floor_is_that_of_up_and_down_or_of_a_condition_measured_twice(tmp_path):
    once = study(bench.write_mat(tmp_path / "a.mat", bench.recording(cambers=(0.0,))))
    assert {c.floor_from for c in once.curves} == {"up and down through the same values"}
    two = [bench.recording(seed=k, cambers=(0.0,), pressures=(83.0,)) for k in (0, 1)]
    twice = {k: np.concatenate([two[0][k], two[1][k]]) for k in two[0]}
    found = study(bench.write_mat(tmp_path / "b.mat", twice))
    assert {c.floor_from for c in found.curves} == {"repeats of a condition"}
    assert all(0.0 < c.floor < 12.0 for c in found.curves)


def toyo_sweeps(tir: Path, grip_at_high_load: float) -> dict[str, np.ndarray]:
    """Sweeps of the shipped tire, with less grip at the highest load."""
    columns = bench.recording(cambers=(0.0,), pressures=(250.0,))
    columns["fz"] = 4.0 * columns["fz"]
    given = {"alpha": columns["alpha"], "pressure": columns["pressure"], "vx": columns["speed"]}
    _, fy, _ = steady_forces(read_tir(tir).coefficients, columns["fz"], **given)
    noise = np.random.default_rng(3).normal(0.0, 12.0, len(fy))
    columns["fy"] = np.where(columns["fz"] > 4000.0, grip_at_high_load, 1.0) * fy + noise
    return columns


def test_a_right_tire_file_is_at_the_floor_and_a_wrong_one_fails_where_it_is_wrong(
    tmp_path, capsys
):
    tir = tmp_path / "toyo.tir"
    tir.write_text(SHIPPED.read_text(encoding="utf-8"))
    right = bench.write_mat(tmp_path / "right.mat", toyo_sweeps(tir, 1.0))
    assert main(["sweeps", str(right), "--tir", str(tir), "--json"]) == 0
    for condition in json.loads(capsys.readouterr().out)["conditions"]:
        assert condition["chance"] > RISK
    wrong = bench.write_mat(tmp_path / "wrong.mat", toyo_sweeps(tir, 0.9))
    assert main(["sweeps", str(wrong), "--tir", str(tir)]) == 0
    out = capsys.readouterr().out
    lines = out[out.index("fails, worst first") :].splitlines()
    assert "4800 N" in lines[2] and "fails in 1 of 3 conditions with a floor" in out
    assert any(line.startswith("by load: ") for line in lines)
    assert "for Fx you still need" in out and "for combined slip you still need" in out


def test_in_python_the_same_numbers_as_the_verb(tmp_path, capsys):
    path, tir = tmp_path / "a.mat", tmp_path / "t.tir"
    bench.write_mat(path, bench.recording(cambers=(0.0,), pressures=(83.0,)))
    tir.write_text(SHIPPED.read_text(encoding="utf-8"))
    assert main(["sweeps", str(path), "--tir", str(tir), "--json"]) == 0
    whole = json.loads(capsys.readouterr().out)
    told = whole["conditions"]
    found = fp.sweeps(path)
    assert json.loads(json.dumps(study(path).to_json(read_tir(str(tir))))) == whole
    table = found.compare(tir)
    assert sorted(table["error"]) == pytest.approx(sorted(c["error"] for c in told))
    assert list(found.conditions["D"]) == pytest.approx(
        [c["formula"]["values"]["D"] for c in told]
    )
    assert found.table.attrs["units"]["alpha"] == "rad" and "temperature" in found.table
    shown = [panel for panel in found.plot(tir).axes if panel.get_visible()]
    assert len(shown) == 2 * len(told)  # Fy and Mz


def test_the_figure_has_the_curves_of_each_condition_the_worst_first(tmp_path):
    columns = tire.sweep(tire.wave(240), (0.0, 4.0))
    columns["FY"] = np.where(columns["FZ"] == tire.LOADS[1], 0.9, 1.0) * columns["FY"]
    del columns["MZ"]
    path, tir = tire.files(tmp_path, tire.text_of(columns))
    found = study(path)
    errors = found.failures(read_tir(str(tir)))
    shares = [e.share for e in errors]
    worst_first = sorted(range(6), key=lambda k: -shares[k])
    assert {round(found.conditions[k].held["fz"]) for k in worst_first[:2]} == {tire.LOADS[1]}
    for file, order in ((read_tir(str(tir)), worst_first), (None, range(6))):
        figure = found.plot(file)
        panels = figure.axes
        assert figure.get_size_inches() == pytest.approx([12.8, 5.0])  # 4 by 2 panels
        shown = [p for p in panels if p.get_visible()]
        assert len(panels) == 8 and len(shown) == 6
        for panel, k in zip(shown, order, strict=True):
            curve, condition = found.curves[k], found.conditions[k]
            wanted = [curve.force, found.formulas[k](curve.slip)]
            wanted += [errors[k].modelled] if file else []
            for line, values in zip(panel.get_lines(), wanted, strict=True):
                np.testing.assert_allclose(line.get_xdata(), np.degrees(curve.slip))
                np.testing.assert_allclose(line.get_ydata(), values)
            (band,) = panel.collections
            edge = band.get_paths()[0].vertices[:, 1]
            ways = np.array([curve.up, curve.down])[:, np.isfinite(curve.up + curve.down)]
            assert set(ways.ravel()) <= set(edge)
            load, camber = condition.held["fz"], np.degrees(condition.held["gamma"])
            assert panel.get_title() == f"{load:.0f} N, {camber:.0f} deg"
            assert (panel.get_xlabel(), panel.get_ylabel()) == ("slip angle [deg]", "Fy [N]")
        (legend,) = shown[0].figure.legends
        assert len(legend.get_texts()) == (4 if file else 3)


def test_a_wrong_name_of_an_axis_system_is_told_with_the_known(tmp_path):
    path = bench.write_mat(tmp_path / "a.mat", bench.recording())
    with pytest.raises(FlatplankError, match="no axis system 'sea'.*iso, sae, adapted"):
        study(path, "sea")


def test_signs_that_belong_to_no_system_are_refused_and_nothing_is_turned(tmp_path, capsys):
    columns = bench.recording()
    path = bench.write_mat(tmp_path / "a.mat", columns, ("fz",))
    with pytest.raises(FlatplankError, match="Fy falls|Fy rises"):
        study(bench.write_mat(tmp_path / "b.mat", columns, ("alpha", "fz")))
    assert study(path).said[0].startswith("axes: SAE J670")
    assert main(["sweeps", str(path), "--axes", "iso"]) == 1
    error = capsys.readouterr().err
    assert "the signs are not those of ISO W" in error and "--axes sae" in error
    slip = bench.recording("kappa")
    slip["fx"] = -slip["fx"]
    with pytest.raises(FlatplankError, match="a driven tire would brake"):
        study(bench.write_mat(tmp_path / "c.mat", slip))


@pytest.mark.parametrize(
    ("name", "content", "reason"),
    [
        ("a.csv", "SA,FY\n1,2,3\n1,2,3\n", "no header of 3 names"),
        ("a.csv", "SA,FY,X\n" + "1,2,3\n" * 80, "no vertical force"),
        ("a.csv", "SA,FY,FZ\n" + "1,2,3\n" * 20, "20 whole samples"),
        ("a.csv", "SA,FY,FZ\n1,2,3\n1,2,3,4\n", "4 values for 3 columns"),
        ("a.csv", "SA,FY,FZ\n" + "1,2,300\n" * 80, "no sweep"),
        ("a.csv", "FX,FY,FZ\n" + "1,2,3\n" * 80, "neither slip angle nor slip"),
        ("a.dat", "words only\n", "no line of numbers"),
        ("a.mat", "no matlab", "not a whole MATLAB file"),
        ("a.mat", "MATLAB 7.3 MAT-file", "not a whole MATLAB file"),
        ("a.xyz", "", "not a file of sweeps"),
    ],
)
def test_a_bad_file_is_refused_in_one_line(name, content, reason, tmp_path, capsys):
    path = tmp_path / name
    path.write_text(content)
    assert main(["sweeps", str(path)]) == 1
    error = capsys.readouterr().err
    assert reason in error and error.count("\n") == 1 and str(path) in error


def test_a_missing_file_is_one_line(tmp_path, capsys):
    assert main(["sweeps", str(tmp_path / "none.mat")]) == 1
    assert "No such file" in capsys.readouterr().err
    assert main(["sweeps", str(tmp_path / "none.mat"), "--tir", "x.tir"]) == 1
