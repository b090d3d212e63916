# SPDX-License-Identifier: Apache-2.0
"""The loop on bad input: one clear line, nothing lost, the good runs go on."""

from __future__ import annotations

import json

import numpy as np
import pytest
from bristles import Truth, campaign, save
from test_disc_effects import OWN

from flatplank_analysis.cli import change, compare, diagnose, effects
from flatplank_analysis.contact_patch.data import from_tables, load_runs
from flatplank_analysis.contact_patch.parameters import NAMES
from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery import modelfile
from flatplank_analysis.effects import consent
from flatplank_analysis.effects.checks import probe_model
from flatplank_analysis.effects.registry import library
from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError
from flatplank_data.table import MeasurementTable

SMALL = (-0.05, -0.01, 0.01, 0.05)
FORCE = "self.force * np.tanh(signal.true_fx / 50.0)"
VARIANTS = """    @classmethod
    def variants(cls, runs, residual):
        {}

    def signal("""


@pytest.fixture(scope="module")
def tables():
    """Eight runs, two of each condition."""
    return campaign(Truth(seed=41, slips=SMALL, repeats=2))


@pytest.fixture(scope="module")
def folder(tables, tmp_path_factory):
    """The same on disk."""
    return save(tables, tmp_path_factory.mktemp("campaign"))


def _own(tmp_path, old: str = "", new: str = ""):
    assert old in OWN
    path = tmp_path / "mine.py"
    path.write_text(OWN.replace(old, new))
    consent.give([path])
    return path


def _variants(body: str) -> tuple[str, str]:
    return "    def signal(", VARIANTS.format(body)


BROKEN = {
    "acts at its null": (
        FORCE,
        FORCE.replace("self.force", "(200.0 + self.force)"),
        "at its null",
    ),
    "variants raises": (*_variants("return runs.facts['none']"), r"variants\(\): raised KeyError"),
    "variants of what": (*_variants("return [{'forse': 1.0}]"), "'forse', which is no parameter"),
    "variants no list": (*_variants("return {'force': 1.0}"), "no list of settings"),
    "taken": ('"rail_friction"', '"road_play"', "road_play"),
    "coordinate": ('"slip level"', '"slip levels"', "'slip levels' is not one of .*slip level"),
    "node": (
        "def signal(self, signal: Signal) -> None:\n        signal.fx = signal.fx + " + FORCE,
        "def node(self, node) -> None:\n        node.slip = node.slip[:, 1:] * self.force",
        r"node\(\): 'slip' has shape \(1, 7\), not \(1, 8\)",
    ),
}


@pytest.mark.parametrize("case", BROKEN)
def test_an_effect_that_breaks_the_contract_is_refused_everywhere(case, folder, tmp_path, capsys):
    old, new, told = BROKEN[case]
    file, model = _own(tmp_path, old, new), tmp_path / "model.yaml"
    assert effects.main(["check", str(file)]) == 1
    shown = capsys.readouterr().out
    assert shown.count("\n") == 1
    with pytest.raises(FlatplankError, match=told) as refused:
        diagnose.main([str(folder), "--effects", str(file)])
    assert str(file) in str(refused.value)
    with pytest.raises(FlatplankError, match=told):
        change.add(["rail_friction", str(folder), "--effects", str(file), "--model", str(model)])
    assert not model.exists()


def test_an_effect_that_fails_on_these_runs_only_is_named(folder, tmp_path):
    body = "return [{}] if runs.names[0].startswith('probe') else runs.facts['none']"
    file = _own(tmp_path, *_variants(body))
    assert effects.main(["check", str(file)]) == 0
    with pytest.raises(FlatplankError, match=r"effect rail_friction, variants\(\): raised KeyErr"):
        compare.main([str(folder), "--effects", str(file)])


def test_a_file_in_the_model_may_be_named_again(folder, tmp_path, monkeypatch, capsys):
    file, model = _own(tmp_path), tmp_path / "model.yaml"
    monkeypatch.chdir(tmp_path)
    line = [str(folder), "--effects", file.name, "--model", str(model), "--json"]
    assert change.add(["rail_friction", *line]) == 0
    (entry,) = modelfile.load_model(model).effects
    assert entry.file == str(file)
    assert compare.main(line) == 0
    capsys.readouterr()
    assert list(library(["mine.py", "./mine.py", file])) == list(library([file]))


def _spoiled(tables, tmp_path, rows, name: str, keep: bool = False):
    """The campaign with a column missing from some runs, or, when kept, full of NaN."""
    out = list(tables)
    for i in rows:
        columns = dict(out[i].columns)
        lost = columns.pop(name)
        out[i] = MeasurementTable(
            columns | ({name: np.full_like(lost, np.nan)} if keep else {}), out[i].info
        )
    return save(out, tmp_path)


@pytest.mark.parametrize("row", [0, 5])
def test_a_channel_that_one_run_lacks_is_dropped_and_told(row, tables, tmp_path):
    campaign_ = Campaign.load(_spoiled(tables, tmp_path, [row], "fz"))
    runs = load_runs(campaign_).runs
    assert runs.runs == len(tables) and runs.channels == ("fx", "fy")
    told = [str(p) for p in campaign_.problems if "goes without this channel" in p.what]
    assert len(told) == 1 and tables[row].info.file in told[0] and "'fz'" in told[0]


def test_a_run_that_cannot_be_used_is_skipped_and_told(tables, tmp_path, capsys):
    folder, model = _spoiled(tables, tmp_path, [2], "wheel_angle"), tmp_path / "model.yaml"
    assert compare.main([str(folder), "--json"]) == 0
    seen = capsys.readouterr()
    assert sum(c["runs"] for c in json.loads(seen.out)["conditions"]) == len(tables) - 1
    assert f"{tables[2].info.file}: no 'wheel_angle': not used" in seen.err
    assert change.add(["hub_gain", str(folder), "--model", str(model)]) == 0
    assert "no 'wheel_angle': not used" in capsys.readouterr().err


def test_a_run_that_ended_early_does_not_shorten_the_others(tables, tmp_path):
    whole = from_tables(tables)
    early = tables[3]
    stop = len(early) // 2
    cut = MeasurementTable({n: c[:stop] for n, c in early.columns.items()}, early.info)
    campaign_ = Campaign.load(save([*tables[:3], cut, *tables[4:]], tmp_path))
    data = load_runs(campaign_)
    assert data.position.shape == (len(tables) - 1, whole.position.shape[1])
    (told,) = [str(p) for p in campaign_.problems]
    assert early.info.file in told and "m is usual for its step: not used" in told


def test_without_a_usable_run_the_first_reason_is_told(tables, tmp_path, capsys):
    folder = _spoiled(tables, tmp_path, range(len(tables)), "fx", keep=True)
    assert diagnose.main([str(folder)]) == 2
    told = capsys.readouterr().err
    assert told.count("\n") == 1 and "no usable slip run" in told
    assert tables[0].info.file in told and "are not numbers" in told


@pytest.fixture(scope="module")
def single(tables, tmp_path_factory):
    """Every condition once."""
    once = [t for t in tables if t.info.start == 1]
    return save(once, tmp_path_factory.mktemp("single"))


def test_a_verdict_without_a_search_is_printed_and_makes_no_page(single, tmp_path, capsys):
    page, out = tmp_path / "page", tmp_path / "out.json"
    line = [str(single), "--json", "--report", str(page), "--out", str(out)]
    assert diagnose.main(line) == 0
    seen = capsys.readouterr()
    assert json.loads(seen.out) == json.loads(out.read_text())
    assert json.loads(seen.out)["verdict"] == "not decidable"
    assert "report: none" in seen.err and not page.exists()


def test_a_place_that_cannot_be_written_is_told_before_the_search(folder, tmp_path, monkeypatch):
    (tmp_path / "file").touch()
    monkeypatch.setattr(Session, "diagnose", lambda *_: pytest.fail("searched"))
    for option, place, told in (
        ("--out", "none/out.json", "no such folder"),
        ("--out", ".", "is a folder"),
        ("--report", "file/page", "is no folder"),
    ):
        with pytest.raises(FlatplankError, match=told):
            diagnose.main([str(folder), option, str(tmp_path / place)])
    with pytest.raises(FlatplankError, match="no such folder"):
        change.add(["hub_gain", str(folder), "--model", str(tmp_path / "none" / "model.yaml")])


def test_add_tells_why_an_effect_cannot_be_added(folder, single, tables, tmp_path):
    model = tmp_path / "model.yaml"
    quiet = tmp_path / "quiet"
    quiet.mkdir()
    weak = [t.with_columns(fy=0.01 * t["fy"]) for t in tables]
    with pytest.raises(FlatplankError, match="'crosstalk_fy' cannot show in these runs"):
        change.add(["crosstalk_fy", str(save(weak, quiet)), "--model", str(model)])
    there = modelfile.ModelFile(effects=(modelfile.Entry("hub_gain"),))
    modelfile.save_model(there, model)
    with pytest.raises(FlatplankError, match="'hub_gain' is in the model already"):
        change.add(["hub_gain", str(folder), "--model", str(model)])
    for verb in (change.add, change.remove):
        with pytest.raises(FlatplankError, match="4 runs: at least 6"):
            effect = "road_play" if verb is change.add else "hub_gain"
            verb([effect, str(single), "--model", str(model)])
    assert modelfile.load_model(model).to_dict() == there.to_dict()


BAD_MODELS = {
    "effects: 3": "'effects' is 3, no list",
    "effects: {road_play: {gap: 1}}": "'effects' is .*, no list",
    "effects: [{name: road_play, gap: 1}]": "effect road_play: unknown key 'gap'",
    "effects: [{name: road_play, parameters: {gab: 1}}]": "effect road_play .*'gab'.*: .*gap",
    "effects: [{name: road_play, parameters: {gap: .nan}}]": "effect road_play: parameter 'gap'",
    "history: 3": "'history' is 3, no list",
    "history: [abc]": "'history' holds 'abc'",
    "base: nonsense": "no base 'nonsense'; write 'base: contact_patch'",
    "parameters: {stif: 1}": "no parameter 'stif'; known: stiff",
    "parameters: {stiff: .nan}": "parameter 'stiff' is nan",
    "campaign: 2026-13-45": "not YAML",
    "base: \xff": "no UTF-8 text",
}


@pytest.mark.parametrize("text", BAD_MODELS)
def test_a_bad_model_file_is_told_in_one_line(text, folder, tmp_path):
    model = tmp_path / "model.yaml"
    content = f"format: {modelfile.FORMAT}\n{text}\n".encode("latin-1")
    model.write_bytes(content)
    for main, line in ((compare.main, []), (diagnose.main, []), (change.add, ["hub_gain"])):
        with pytest.raises(FlatplankError, match=BAD_MODELS[text]) as told:
            main([*line, str(folder), "--model", str(model)])
        assert str(told.value).startswith(str(model))
    assert model.read_bytes() == content


def test_a_folder_is_no_model_file(folder, tmp_path):
    with pytest.raises(FlatplankError, match="cannot be read"):
        compare.main([str(folder), "--model", str(tmp_path)])


def test_every_parameter_of_the_base_is_known_by_name():
    """The probe campaign differs in everything that a parameter may follow."""
    assert tuple(p.name for p in probe_model().parameters) == NAMES


def test_a_model_file_that_changed_meanwhile_is_not_overwritten(tmp_path):
    path = tmp_path / "model.yaml"
    mine = modelfile.save_unchanged(modelfile.ModelFile().with_step("start", "", {}), path)
    mine = modelfile.save_unchanged(mine.with_step("add", "hub_gain", {}), path)
    theirs = modelfile.load_model(path)
    assert theirs.to_dict() == mine.to_dict()
    theirs = modelfile.save_unchanged(theirs.with_step("add", "road_play", {}), path)
    late = mine.with_step("add", "wear", {})
    with pytest.raises(FlatplankError, match="changed meanwhile"):
        modelfile.save_unchanged(late, path)
    assert modelfile.load_model(path).to_dict() == theirs.to_dict()
    path.unlink()
    with pytest.raises(FlatplankError, match="changed meanwhile"):
        modelfile.save_unchanged(late, path)
    assert not path.exists()


@pytest.mark.parametrize("verb", [change.add, change.remove])
def test_add_and_remove_keep_what_somebody_else_wrote(verb, folder, tmp_path, monkeypatch):
    path = tmp_path / "model.yaml"
    modelfile.save_model(modelfile.ModelFile(campaign=str(folder)), path)
    theirs = modelfile.ModelFile().with_step("add", "road_play", {})

    def refit(session, model, name, alike=None):
        modelfile.save_model(theirs, path)
        return model.with_step("add", name, {}), None, {}

    monkeypatch.setattr(Session, verb.__name__, refit)
    with pytest.raises(FlatplankError, match="changed meanwhile"):
        verb(["hub_gain", "--model", str(path)])
    assert modelfile.load_model(path).to_dict() == theirs.to_dict()


def test_foreign_columns_are_mapped(tables, tmp_path, capsys):
    foreign = []
    for table in tables:
        columns = dict(table.columns)
        columns["pull"] = columns.pop("fx")
        foreign.append(MeasurementTable(columns, table.info))
    folder, mapping = save(foreign, tmp_path), tmp_path / "mapping.yml"
    mapping.write_text("columns: {pull: fx}\n")
    assert compare.main([str(folder)]) == 2
    assert compare.main([str(folder), "--mapping", str(mapping)]) == 0
    assert "all: error" in capsys.readouterr().out
