# SPDX-License-Identifier: Apache-2.0
"""The package in a notebook: the five lines, with the numbers of the verbs."""

from __future__ import annotations

import json
import pkgutil
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from bristles import Truth, campaign, save
from matplotlib.figure import Figure

import flatplank_analysis as fp
from asked import asked
from flatplank_analysis.cli import change, compare, diagnose
from flatplank_analysis.discovery.report.text import text_of
from flatplank_sim.sealed import seal
from flatplank_sim.sealed.score import score
from flatplank_tire import shipped_tir, write_tir
from printed_words import unknown_in_page

PAGE = Path(__file__).resolve().parents[2] / "docs/guide/python.md"
SMALL = (-0.05, -0.01, 0.01, 0.05)
HEAVY = ("scipy", "pandas", "matplotlib", "numpy", "pyarrow")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A campaign on disk with a backlash of half a millimetre."""
    truth = Truth(seed=41, slips=SMALL, repeats=2, backlash=5e-4)
    return save(campaign(truth), tmp_path_factory.mktemp("campaign"))


@pytest.fixture(scope="module")
def runs(folder):
    return fp.load(folder)


@pytest.fixture(scope="module")
def model(runs):
    return fp.fit(runs)


@pytest.fixture(scope="module")
def grown(model):
    return model.add("drive_backlash")


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """Where the verb writes its page."""
    return tmp_path_factory.mktemp("page")


@pytest.fixture(scope="module")
def told(folder, page):
    """What the verb says of the campaign, for programs."""
    return asked(diagnose.main, folder, "--report", page)


def test_every_public_name_is_there():
    for name in fp.__all__:
        assert getattr(fp, name).__name__ == name


def test_the_package_alone_imports_nothing_heavy():
    """Nodes import it at their start."""
    code = f"import sys, flatplank_analysis; print([m for m in {HEAVY} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
    assert set(fp.__all__) <= set(dir(fp))
    with pytest.raises(AttributeError, match="has no attribute 'lod'"):
        _ = fp.lod


def test_runs_are_a_table(runs):
    assert isinstance(runs, pd.DataFrame) and len(runs) == 2 * len(SMALL)
    assert sorted(set(runs.kappa)) == list(SMALL) and set(runs.fz) == {3700.0}
    assert runs.attrs["units"]["fz"] == "N" and runs.attrs["units"]["pressure"] == "bar"
    assert runs.groupby("condition").size().tolist() == [2] * len(SMALL)


def test_a_run_has_a_table_with_units(runs):
    run = runs.run[3]
    assert str(run) == runs.name[3] and run.info.kappa == runs.kappa[3]
    table = run.table
    assert table.attrs["units"]["fx"] == "N" and table.attrs["units"]["wheel_angle"] == "rad"
    assert set(table.attrs["units"]) == set(table.columns)
    np.testing.assert_array_equal(table.fx, run.measured["fx"])


def test_what_is_beyond_a_floor_is_the_error_less_the_floor(tmp_path):
    """A wave that turns with the wheel is lost in the mean over the starts, not in the error."""
    truth = Truth(seed=7, slips=(-0.02, 0.0, 0.02), repeats=3, parasitic=60.0)
    runs = fp.load(save(campaign(truth), tmp_path))
    found = fp.fit(runs).compare(runs)
    for row in found.conditions.itertuples():
        assert row.rmse > 2.0 * row.floor
        assert row.beyond == pytest.approx(np.sqrt(row.rmse**2 - row.floor**2), rel=1e-3)
    assert f"beyond it {found.numbers['beyond']:.1f} N" in repr(found)
    assert "over the wheel angle: " in repr(found)


def test_fit_has_the_numbers_of_compare(model, folder):
    verb = asked(compare.main, folder)
    assert dict(model.compare(fp.load(folder)).numbers) == verb
    table = model.parameters
    assert {n: float(f"{v:.6g}") for n, v in zip(table.parameter, table.value, strict=True)} == {
        n: verb["parameters"][n] for n in table.parameter
    }
    assert model.effects == [] and "model: tire" in repr(model)


def test_add_has_the_numbers_of_the_verb(model, grown, folder, tmp_path):
    path = tmp_path / "model.yaml"
    verb = asked(change.add, "drive_backlash", folder, "--model", path)
    assert {k: v for k, v in verb.items() if k not in ("model", "effect")} == dict(grown.numbers)
    mine = grown.save(tmp_path / "mine.yaml")
    assert yaml.safe_load(mine.read_text()) == yaml.safe_load(path.read_text())
    assert "drive_backlash: " in repr(grown) and model.effects == []

    again = asked(change.remove, "drive_backlash", folder, "--model", path)
    smaller = grown.remove("drive_backlash")
    assert smaller.numbers["rmse"] == again["rmse"]
    assert smaller.save(tmp_path / "less.yaml").read_text() == path.read_text()
    assert grown.undo().effects == [] and smaller.undo().effects == ["drive_backlash"]
    assert smaller.undo().file.parameters == grown.file.parameters
    read = fp.fit(fp.load(folder), model=mine)
    assert read.effects == ["drive_backlash"]
    with pytest.raises(fp.FlatplankError, match="changed meanwhile"):
        grown.save(mine)


def test_diagnose_writes_contract_and_page(told, page, tmp_path):
    keys = {
        "verdict", "effects", "floor_rmse", "rmse_before", "rmse_after", "held_out_before",
        "held_out_after", "unexplained", "next_run", "seconds",
    }  # fmt: skip
    assert keys <= set(told)
    (effect,) = told["effects"]
    assert told["verdict"] == "found group"
    assert {effect["name"], *effect["class"]} == {"drive_backlash", "rack_backlash"}
    assert effect["size"] == pytest.approx(5e-4, rel=0.15)
    assert told["rmse_after"] < told["rmse_before"]
    assert told["held_out_after"] < 1.1 * told["floor_rmse"]
    assert told["next_run"]["what"]
    assert {
        "name", "kind", "size", "unit", "interval", "class", "held_out_gain", "probability",
    } <= set(effect)  # fmt: skip
    html = (page / "index.html").read_text()
    assert "<svg" in html and "http://" not in html.replace("http://www.w3.org", "")
    assert ">effect</abbr></th>" in html and unknown_in_page(html) == []
    assert 'title="Backlash of the wheel drive: Gears of the wheel drive cross' in html
    verdict = html[html.index('class="verdict"') :].split("</p>")[0]
    assert all(word in verdict for word in [told["verdict"], "0.5", "mm (90 %:", *effect["class"]])
    assert "Dots and lines differ by" in html
    assert json.loads((page / "diagnosis.json").read_text())["verdict"] == told["verdict"]
    for name in ("conditions", "waterfall", "collapse0", "map0"):
        assert (page / f"{name}.png").stat().st_size > 2000
        assert (page / f"{name}.svg").read_text().startswith("<?xml")
    answer = {"effects": [{"name": "drive_backlash", "size": 5e-4, "unit": "m", "class": []}]}
    seal.seal(answer, tmp_path)
    assert "drive_backlash" not in (tmp_path / seal.NAME).read_text()
    result = score(told, seal.unseal(tmp_path))
    assert result["right"] and result["first_right"] and not result["false"]


def test_diagnosis_is_that_of_the_verb(runs, model, told, tmp_path):
    found, verb = fp.diagnose(runs, model), told
    mine = found.to_dict()
    assert {k: v for k, v in mine.items() if k != "seconds"} == {
        k: v for k, v in verb.items() if k != "seconds"
    }
    assert repr(found) == text_of(found.result, found.campaign)
    assert found.verdict == verb["verdict"]
    assert list(found.effects.name) == [e["name"] for e in verb["effects"]] == ["drive_backlash"]
    assert found.next_run == verb["next_run"]
    for what in ("conditions", "ranking", "residual", "waterfall", "drive_backlash"):
        assert isinstance(found.plot(what), Figure)
    html = found._repr_html_()
    assert html.count("<img") == 2 and "verdict: " in html
    assert found.report(tmp_path / "page").read_text().count("<svg") > 4
    with pytest.raises(fp.FlatplankError, match="no figure 'maps'; known: conditions"):
        found.plot("maps")


def test_comparison_draws_before_and_after(model, grown, runs):
    figure = grown.compare(runs).plot()
    assert isinstance(figure, Figure) and figure._repr_png_().startswith(b"\x89PNG")
    bars = figure.axes[0].containers
    before, after = ([bar.get_height() for bar in group] for group in bars)
    assert np.mean(after) < np.mean(before)
    np.testing.assert_allclose(before, model.compare(runs).conditions.rmse, atol=1e-3)
    np.testing.assert_allclose(after, grown.compare(runs).conditions.rmse, atol=1e-3)
    shown = grown.compare(runs)
    assert "error [N]" in repr(shown) and "<img" in shown._repr_html_()
    for what in ("residual", *shown.maps):
        assert isinstance(shown.plot(what), Figure)
    assert "tire</td>" in grown._repr_html_() and isinstance(grown.plot(), Figure)
    assert list(grown.history.action) == ["start", "add"]


def test_some_of_the_runs_and_other_runs(model, runs):
    driving = fp.fit(runs[runs.kappa > 0.0])
    assert len(driving.compare(runs[runs.kappa > 0.0]).conditions) == 2
    assert len(driving.compare(runs).conditions) == len(SMALL)
    both = pd.concat([runs[runs.kappa < 0.0], runs[runs.kappa > 0.0]])
    assert fp.fit(both).compare(both).numbers["rmse"] == pytest.approx(
        model.compare(runs).numbers["rmse"], rel=1e-3
    )


@pytest.mark.parametrize(
    ("work", "line"),
    [
        (lambda _: fp.load("/nowhere"), "/nowhere"),
        (lambda _: fp.fit("campaign"), "str is no table of runs; make one by load"),
        (lambda runs: fp.fit(runs[:0]), "no run is left"),
        (lambda runs: fp.fit(runs, model="/nowhere.yaml"), "no such model file"),
        (lambda runs: fp.fit(runs.drop_duplicates("kappa")), "repeat one condition"),
    ],
)
def test_bad_input_is_one_line(runs, work, line):
    with pytest.raises(fp.FlatplankError, match=line) as told:
        work(runs)
    assert "\n" not in str(told.value)


def test_what_cannot_be_used_is_a_warning(folder, tmp_path):
    for file in folder.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    broken = next(tmp_path.glob("*.parquet"))
    broken.unlink()
    with pytest.warns(UserWarning, match=f"{re.escape(broken.name)}.*no such file"):
        assert len(fp.load(tmp_path)) == 2 * len(SMALL) - 1


def test_intervals_hold_what_was_hidden(grown):
    """The size of the backlash, and that every number says what it is known from."""
    table = grown.parameters.set_index("parameter")
    size = table[table.of == "drive_backlash"].iloc[0]
    assert size.low < 5e-4 < size.high and size.high - size.low < 5e-4
    assert (table["determined by"] != "").all()
    assert ((table.low <= table.value) & (table.value <= table.high)).all()


def test_the_page_runs(tmp_path, monkeypatch):
    """Every line of docs/guide/python.md, on a road that plays."""
    folder = tmp_path / "campaign"
    folder.mkdir()
    save(campaign(Truth(seed=43, slips=SMALL, repeats=2, play=4e-4)), folder)
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert len(blocks) == 6
    write_tir(shipped_tir(), "tire.tir")
    names: dict[str, object] = {}
    for block in blocks:
        exec(compile(block, str(PAGE), "exec"), names)
    assert names["model"].effects == ["road_play"]
    assert list(names["answer"].effects["name"]) == ["drag"]
    assert abs(names["fy"]) > 1000.0
    told = names["diagnosis"].effects.iloc[0]
    assert "road_play" in [told["name"], *told["class"]]


def test_no_function_has_the_name_of_a_package():
    """Once such a package was imported, it would stand in the place of the function."""
    assert not {m.name for m in pkgutil.iter_modules(fp.__path__)} & set(fp.__all__)
