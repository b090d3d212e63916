# SPDX-License-Identifier: Apache-2.0
"""The loop on the command line: compare, add, remove, the model file, the report."""

from __future__ import annotations

import json
from dataclasses import replace
from types import SimpleNamespace

import pytest
import yaml
from bristles import Truth, campaign, save

from flatplank_analysis.cli import change, compare, effects
from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery import modelfile
from flatplank_analysis.effects.registry import library
from flatplank_data import files
from flatplank_data.errors import FlatplankError

SMALL = (-0.05, -0.01, 0.01, 0.05)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A campaign on disk with a backlash of half a millimetre."""
    truth = Truth(seed=41, slips=SMALL, repeats=2, backlash=5e-4)
    return save(campaign(truth), tmp_path_factory.mktemp("campaign"))


def _json(capsys):
    return json.loads(capsys.readouterr().out)


def test_loop(folder, tmp_path, capsys):
    model = tmp_path / "model.yaml"
    assert compare.main([str(folder), "--json"]) == 0
    before = _json(capsys)
    # the limit of the verdict "at floor"
    assert before["unexplained"] > 0.3 * before["floor"]
    assert len(before["conditions"]) == len(SMALL)

    assert change.add(["drive_backlash", str(folder), "--model", str(model), "--json"]) == 0
    added = _json(capsys)
    assert added["size"] == pytest.approx(5e-4, rel=0.15)
    assert added["rmse"] < 0.7 * added["rmse_before"]
    content = yaml.safe_load(model.read_text())
    assert [e["name"] for e in content["effects"]] == ["drive_backlash"]
    assert [h["action"] for h in content["history"]] == ["start", "add"]
    added_content = content
    (entry,) = content["effects"]
    assert entry.get("or", []) == [m["name"] for m in added.get("class", [])]

    assert compare.main([str(folder), "--model", str(model)]) == 0
    assert "floor" in capsys.readouterr().out

    assert change.remove(["drive_backlash", "--model", str(model)]) == 0
    content = yaml.safe_load(model.read_text())
    assert content["effects"] == []
    assert [h["action"] for h in content["history"]] == ["start", "add", "remove"]
    with pytest.raises(FlatplankError, match="not in the model"):
        change.remove(["drive_backlash", "--model", str(model)])
    assert yaml.safe_load(model.read_text()) == content

    assert change.undo(["--model", str(model)]) == 0
    assert "remove drive_backlash undone" in capsys.readouterr().out
    assert yaml.safe_load(model.read_text()) == added_content
    assert change.undo(["--model", str(model), "--json"]) == 0
    back = _json(capsys)
    assert back["undone"] == {"action": "add", "effect": "drive_backlash"}
    assert back["effects"] == [] and back["rmse"] == added["rmse_before"]
    with pytest.raises(FlatplankError, match="nothing to undo"):
        change.undo(["--model", str(model)])


def test_undo_goes_back_to_the_number(tmp_path):
    """Base parameters, effects and the user's file; a file that was written by hand, too."""
    path = tmp_path / "m.yaml"
    mine = modelfile.Entry("mine", {"size": 0.1}, "/home/me/mine.py")
    first = modelfile.ModelFile(parameters={"stiff": 9e4}).with_step("start", "", {"rmse": 9.0})
    second = replace(first, parameters={"stiff": 1.0 / 3.0}, effects=(mine,))
    second = second.with_step("add", "mine", {"rmse": 5.0})
    third = replace(second, parameters={"stiff": 8e4}, effects=())
    modelfile.save_model(third.with_step("remove", "mine", {"rmse": 9.0}), path)
    back = modelfile.load_model(path).undone()
    assert back == second
    assert back.effects[0].file == "/home/me/mine.py"
    assert back.undone() == first
    old = replace(second, history=tuple({"step": i, "effects": []} for i in range(2)))
    with pytest.raises(FlatplankError, match="no base parameters"):
        old.undone()


def test_waterfall_goes_on_from_the_history(monkeypatch):
    from flatplank_analysis.discovery.report import page

    found = [{"name": "base", "rmse": 5.0}, {"name": "+ wear", "rmse": 2.0}]
    monkeypatch.setattr(page.figures, "steps_of", lambda _: found)
    fit = SimpleNamespace(terms=())
    first = SimpleNamespace(state=SimpleNamespace(fit=fit))
    search = SimpleNamespace(steps=[first])
    history = [
        {"action": "start", "effect": "", "rmse": 9.0, "effects": []},
        {"action": "add", "effect": "lag", "rmse": 5.0, "effects": [{"name": "lag"}]},
        {"action": "remove", "effect": "lag", "rmse": 9.0, "effects": []},
    ]

    def names(history) -> list[str]:
        return [s["name"] for s in page.waterfall_steps(search, history)]

    assert names(history) == ["start", "+ lag", "− lag", "+ wear"]
    assert names(()) == ["base", "+ wear"]
    # the file went on since the search began
    assert names(history[:2]) == ["start", "+ lag"]


def test_effects_verb(capsys, tmp_path):
    assert effects.main([]) == 0
    assert "road_play" in capsys.readouterr().out
    assert effects.main(["road_play", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["parameters"][0]["unit"] == "m"
    bad = tmp_path / "bad.py"
    bad.write_text(
        "from dataclasses import dataclass\n"
        "from flatplank_analysis.effects.base import TireEffect\n"
        "@dataclass(frozen=True)\nclass A(TireEffect):\n    identifier = 'a'\n"
    )
    assert effects.main(["check", str(bad), "--trust", str(bad)]) == 1
    assert "missing" in capsys.readouterr().out


def test_model_file_round_trip_and_faults(tmp_path):
    path = tmp_path / "m.yaml"
    model = modelfile.ModelFile(
        parameters={"stiff": 9e4}, effects=(modelfile.Entry("road_play", {"gap": 1e-3}),)
    ).with_step("add", "road_play", {"rmse": 10.0})
    modelfile.save_model(model, path)
    assert modelfile.load_model(path).to_dict() == model.to_dict()
    assert [p.name for p in tmp_path.iterdir()] == ["m.yaml"]
    path.write_text("format: flatplank-discovery-model/1\nefects: []\n")
    with pytest.raises(FlatplankError, match="efects"):
        modelfile.load_model(path)
    with pytest.raises(FlatplankError, match="no such model"):
        modelfile.load_model(tmp_path / "none.yaml")


def test_a_failed_write_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "m.yaml"
    files.write_atomic(path, "old")
    monkeypatch.setattr("os.replace", lambda *_: (_ for _ in ()).throw(OSError("full")))
    with pytest.raises(FlatplankError, match="m.yaml: cannot be written .full."):
        files.write_atomic(path, "new")
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["m.yaml"]


def test_a_model_file_keeps_a_class_and_refuses_its_other_member(tmp_path):
    """'A or B' in the file, also after a refit; B cannot be added beside it. Files without a class
    are as they were."""
    path = tmp_path / "model.yaml"
    model = modelfile.ModelFile(effects=(modelfile.Entry("rack_backlash", {"gap": 7e-4}),))
    assert "or" not in model.state()["effects"][0]
    modelfile.save_model(
        model.with_class(["road_play"]).with_step("add", "rack_backlash", {}), path
    )
    read = modelfile.load_model(path)
    assert read.effects[0].words == "rack_backlash or road_play"
    assert read.history[0]["effects"][0]["or"] == ["road_play"]
    session = SimpleNamespace(effect_of=lambda *_: library()["road_play"])
    with pytest.raises(FlatplankError, match="may be what is in the model as 'rack_backlash or"):
        Session.add(session, read, "road_play")
    path.write_text(path.read_text().replace("  - road_play", "    road_play", 1))
    with pytest.raises(FlatplankError, match="no list"):
        modelfile.load_model(path)
