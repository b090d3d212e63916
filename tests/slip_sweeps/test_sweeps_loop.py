# SPDX-License-Identifier: Apache-2.0
"""The loop on sweeps: the verbs take a file as they take a campaign."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from series_of_sweeps import series_in

import flatplank_analysis as fp
from asked import asked
from flatplank_analysis.cli import change, compare, confirm, diagnose
from flatplank_analysis.cli import sweeps as sweeps_verb
from flatplank_analysis.slip_sweeps.model import sweep_model
from flatplank_analysis.slip_sweeps.study import study
from flatplank_data.errors import FlatplankError
from flatplank_tire.tir import read_tir
from flatplank_validation.sweep_sets.brush import BASE, Brush


@pytest.fixture(scope="module")
def bench(tmp_path_factory) -> Path:
    """A tire file, two series of a tire whose friction falls with temperature, and a cool one."""
    brushes = {
        "hot": (Brush(over_temperature=0.003), 1),
        "again": (Brush(over_temperature=0.003), 2),
        "cool": (Brush(), 3),
    }
    return series_in(tmp_path_factory.mktemp("bench"), brushes)


def test_the_loop(bench) -> None:
    file, tir = bench / "hot.csv", ("--tir", bench / "tire.tir")
    before = asked(compare.main, file, *tir)
    assert before["floor_from"] == "repeats of a condition"
    found = asked(diagnose.main, file, *tir)
    assert found["verdict"] == "found" and found["next_run"]["shows"]
    added = asked(change.add, "grip_temperature", file, *tir)
    assert added["rmse"] < 0.4 * added["rmse_before"]
    # the model file beside the sweeps knows its tire file
    assert asked(compare.main, file)["rmse"] == pytest.approx(added["rmse"], rel=0.02)
    again = asked(confirm.main, "grip_temperature", file, "--with", bench / "again.csv")
    assert again["verdict"] == "confirmed", again
    cool = asked(confirm.main, "grip_temperature", file, "--with", bench / "cool.csv")
    assert cool["verdict"] == "not confirmed"
    with pytest.raises(FlatplankError, match="file of the search"):
        confirm.main(["grip_temperature", str(file), "--with", str(file)])
    asked(change.undo, file)
    assert asked(compare.main, file)["effects"] == []


def test_a_file_that_was_fitted_to_the_sweeps_hides_nothing_that_its_equations_lack(
    bench,
) -> None:
    """Pressure and ply steer of the fitted file hold a part of the temperature: the base fits them
    again beside the effect."""
    file, own = str(bench / "again.csv"), str(bench / "own.tir")
    assert sweeps_verb.main([file, "--fit", own]) == 0
    found = asked(diagnose.main, file, "--tir", own)
    assert [e["name"] for e in found["effects"]] == ["grip_temperature"]
    assert found["verdict"] == "found"
    assert found["effects"][0]["size"] == pytest.approx(-0.003, rel=0.1)
    asked(change.add, "grip_temperature", file, "--tir", own)
    told = asked(confirm.main, "grip_temperature", file, "--with", bench / "hot.csv")
    assert told["verdict"] == "confirmed", told


def test_what_lacks_is_said_in_a_line(bench, tmp_path) -> None:
    file = shutil.copy(bench / "cool.csv", tmp_path)
    with pytest.raises(FlatplankError, match="no tire file"):
        compare.main([str(file)])
    with pytest.raises(FlatplankError, match="no sweep of the"):
        diagnose.main([str(file), "--tir", str(BASE), "--swept", "kappa"])
    with pytest.raises(FlatplankError, match="these sweeps can show.*known"):
        change.add(["road_play", str(file), "--tir", str(BASE)])
    mapping = tmp_path / "map.yaml"
    mapping.write_text("axis: iso")
    with pytest.raises(FlatplankError, match="unknown key 'axis'.*axes"):
        compare.main([str(file), "--tir", str(BASE), "--mapping", str(mapping)])


def test_several_files_are_one_search(bench, tmp_path) -> None:
    """Time and distance go on from file to file."""
    tir = ("--tir", bench / "tire.tir")
    files = [shutil.copy(bench / f"{name}.csv", tmp_path) for name in ("hot", "again")]
    one = asked(diagnose.main, files[0], *tir)
    both = asked(diagnose.main, *files, *tir)
    assert [e["name"] for e in both["effects"]] == ["grip_temperature"]
    width = [float(np.ptp(found["effects"][0]["interval"])) for found in (one, both)]
    assert width[1] < width[0]
    read = fp.sweeps(files)
    (named,) = read.diagnose(bench / "tire.tir").result.to_dict()["effects"]
    assert named["interval"] == both["effects"][0]["interval"]
    assert set(read.compare(BASE).file) == set(map(str, files))
    added = asked(change.add, "grip_temperature", *files, *tir)
    assert added["rmse"] < 0.4 * added["rmse_before"]
    again = ("grip_temperature", *map(str, files), "--with", str(files[1]))
    with pytest.raises(FlatplankError, match="file of the search"):
        confirm.main([*again, *map(str, tir)])
    runs = sweep_model([study(str(f)) for f in files], read_tir(BASE)).runs
    half = runs.runs // 2
    for name in ("time", "distance"):
        values = runs.coordinates[name].values
        assert values[:half].max() <= values[half:].min()
    assert (np.diff(runs.order) != 0).all() and runs.order[:half].max() < runs.order[half:].min()
