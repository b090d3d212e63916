# SPDX-License-Identifier: Apache-2.0
"""Looking at a campaign runs none of its Python: proposals are data, other files need consent."""

from __future__ import annotations

import os
import py_compile
import shutil
from pathlib import Path

import numpy as np
import pytest
import yaml
from bristles import Truth, campaign, save
from test_disc_effects import OWN

import flatplank_analysis as fp
from flatplank_analysis.cli import (
    change,
    common,
    compare,
    confirm,
    diagnose,
    effects,
    propose,
    report,
    table,
)
from flatplank_analysis.discovery import modelfile
from flatplank_analysis.discovery.model import ParameterSet
from flatplank_analysis.discovery.modelfile import Entry, ModelFile, load_model
from flatplank_analysis.effects import consent
from flatplank_analysis.effects.checks import probe_of
from flatplank_analysis.effects.grammar import former
from flatplank_analysis.effects.grammar.file import sentence_of, text_of
from flatplank_analysis.effects.registry import load_file
from flatplank_data.errors import FlatplankError
from flatplank_data.yaml_text import dump_yaml

FORMER = Path(__file__).with_name("former")
MARK = "import pathlib; pathlib.Path({!r}).write_text('ran')\n"


@pytest.fixture(autouse=True)
def own_list(tmp_path, monkeypatch):
    """A user who has allowed nothing yet."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    monkeypatch.setattr(consent, "_HERE", set())


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Eight runs, two of each condition."""
    tables = campaign(Truth(seed=41, slips=(-0.05, -0.01, 0.01, 0.05), repeats=2))
    return save(tables, tmp_path_factory.mktemp("runs"))


@pytest.fixture
def hostile(runs, tmp_path):
    """A colleague's campaign: its model names a file that leaves a mark when it runs."""
    folder = tmp_path / "colleague"
    shutil.copytree(runs, folder)
    (folder / "some.py").write_text(MARK.format(str(tmp_path / "mark")) + OWN)
    write_model(folder, "some.py")
    return folder


def write_model(folder: Path, file: str) -> None:
    entry = {"name": "rail_friction", "parameters": {"force": 10.0}, "file": file}
    line = {"step": 0, "action": "start", "effect": "", "parameters": {}, "effects": [entry]}
    model = {"format": modelfile.FORMAT, "effects": [entry], "history": [line, line]}
    (folder / "model.yaml").write_text(dump_yaml(model))


LOOKS = {
    "compare": lambda d: compare.main([d]),
    "diagnose": lambda d: diagnose.main([d, "--model", f"{d}/model.yaml"]),
    "diagnose --effects": lambda d: diagnose.main([d, "--effects", f"{d}/some.py"]),
    "add": lambda d: change.add(["wear", d]),
    "remove": lambda d: change.remove(["rail_friction", d]),
    "propose": lambda d: propose.main([d]),
    "confirm NAME": lambda d: confirm.main(["some", d, "--with", d]),
    "confirm FILE": lambda d: confirm.main([f"{d}/some.py", d, "--with", d]),
    "effects check": lambda d: effects.main(["check", f"{d}/some.py"]),
    "effects": lambda d: effects.main(["--effects", f"{d}/some.py"]),
    "fp.fit": lambda d: fp.fit(fp.load(d), model=f"{d}/model.yaml"),
    "fp.diagnose": lambda d: fp.diagnose(fp.load(d), effects=[f"{d}/some.py"]),
}


@pytest.mark.parametrize("look", LOOKS)
def test_nothing_of_a_campaign_runs_unasked(look, hostile, tmp_path):
    with pytest.raises(
        FlatplankError, match="not allowed to run; read it, then add: --trust "
    ) as refused:
        LOOKS[look](str(hostile))
    assert "\n" not in str(refused.value)
    assert not (tmp_path / "mark").exists()


@pytest.mark.parametrize(
    "look", [lambda d: table.main([d]), lambda d: report.main([d]),
             lambda d: fp.load(d), lambda d: change.undo([d])],
    ids=["table", "report", "fp.load", "undo"],
)  # fmt: skip
def test_what_needs_no_effect_neither_runs_nor_asks(look, hostile, tmp_path):
    look(str(hostile))
    assert not (tmp_path / "mark").exists()


def test_the_text_that_is_read_is_what_runs(hostile, tmp_path):
    """An encoding in which a comment ends early, bytes that are no text, marks that reorder."""
    file = hostile / "some.py"
    hidden = "# -*- coding: utf-7 -*-\n# +AAo-" + MARK.format(str(tmp_path / "mark"))
    file.write_text(hidden + OWN)
    assert compare.main([str(hostile), "--trust", str(file)]) == 0
    assert not (tmp_path / "mark").exists()
    file.write_bytes(b"# \xff\n" + OWN.encode())
    with pytest.raises(FlatplankError, match="is not UTF-8"):
        compare.main([str(hostile), "--trust", str(file)])
    assert consent.shown("a = 1\r\n\tb # \u202e\u200b\x0c\rü") == (
        "a = 1\n\tb # \\u202e\\u200b\\x0c\\rü"
    )


def test_consent_is_for_this_content_and_remembered(hostile, tmp_path, capsys):
    file = hostile / "some.py"
    assert compare.main([str(hostile), "--trust", str(file)]) == 0
    assert (tmp_path / "mark").exists()
    consent._HERE.clear()  # another program
    assert compare.main([str(hostile)]) == 0
    assert consent.list_of_user().read_text().split()[0] == consent.digest(file.read_bytes())
    file.write_text(file.read_text() + "\n")
    with pytest.raises(consent.ConsentError):
        compare.main([str(hostile)])


def test_python_asks_by_an_argument(hostile, tmp_path):
    model = fp.fit(fp.load(hostile), model=hostile / "model.yaml", trust=[hostile / "some.py"])
    assert model.effects == ["rail_friction"] and (tmp_path / "mark").exists()


def test_a_list_that_cannot_be_written_allows_once(hostile, tmp_path, capsys):
    (tmp_path / "config").write_text("a file where the folder should be")
    consent.give([hostile / "some.py"])
    assert "this time only" in capsys.readouterr().err
    assert load_file(hostile / "some.py")


def test_old_byte_code_does_not_run_in_place_of_the_allowed_text(tmp_path):
    """Python takes a `__pycache__` whose date and size fit, whatever is in it."""
    file = tmp_path / "mine.py"
    evil = MARK.format(str(tmp_path / "mark"))
    size = max(len(OWN), len(evil)) + 9
    file.write_text(evil.ljust(size, "#"))
    py_compile.compile(str(file), doraise=True)
    stamp = file.stat()
    file.write_text((OWN + "\n").ljust(size, "#"))
    os.utime(file, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))
    consent.give([file])
    assert [e.identifier for e in load_file(file)] == ["rail_friction"]
    assert not (tmp_path / "mark").exists()


@pytest.mark.parametrize("name", ["../some.py", "link.py", "os.system", "some.yaml", "/dev/zero"])
def test_other_ways_to_a_file_run_nothing_either(name, hostile, tmp_path):
    shutil.move(hostile / "some.py", tmp_path / "some.py")
    (hostile / "link.py").symlink_to(tmp_path / "some.py")
    shutil.copy(tmp_path / "some.py", hostile / "some.yaml")
    write_model(hostile, name)
    with pytest.raises(FlatplankError):
        compare.main([str(hostile)])
    assert not (tmp_path / "mark").exists()


@pytest.mark.parametrize("place", ["model.yaml", "campaign.yaml", "proposed.yaml"])
def test_yaml_makes_no_objects(place, hostile, tmp_path):
    mark = tmp_path / "mark"
    (hostile / place).write_text(f'!!python/object/apply:os.system ["touch {mark}"]\n')
    write_model(hostile, "proposed.yaml") if place == "proposed.yaml" else None
    with pytest.raises(FlatplankError):
        compare.main([str(hostile)])
    assert not mark.exists()


RMS = {
    "beat": 11.5650430891529,
    "delay_bump": 0.06260349551425592,
    "fx_bump": 1.357413883524726,
    "fx_constant": 3.625862622393297,
    "fx_lag": 1.7683912779698825,
    "fx_ramp": 1.1954998283242826,
    "fx_relaxation": 5.150391363182283,
    "fx_ringing": 1.6158247253332505,
    "stiffness_threshold": 0.8936723867473742,
}
"""file of an earlier version -> change of the forces by its Python at the screening steps [N]"""

OF_THEN = {"carcass": 2.5e5, "carcass_y": 1.5e5, "fx_offset": -30.0}
"""values of the base for which these numbers were computed, where its starts are others today"""


@pytest.mark.parametrize("name", RMS)
def test_an_old_proposal_is_read_as_data_and_does_the_same(name, tmp_path):
    file = tmp_path / "proposed.py"
    shutil.copy(FORMER / f"{name}.txt", file)
    (effect,) = load_file(file)
    model = probe_of(effect)
    base = np.array([OF_THEN.get(p.name, p.null) for p in model.parameters])
    values = {p.name: p.screen or p.null for p in effect.parameters()}
    (plain,) = model.predict([ParameterSet(base)])
    (out,) = model.predict([ParameterSet(base, ((effect, effect.vector(values)),))])
    assert np.sqrt(np.mean((out - plain) ** 2)) == pytest.approx(RMS[name], rel=1e-6)
    assert effect.interval == (1.0, 2.0) and "27 runs" in effect.sentence.evidence[0]
    again = sentence_of(text_of(effect.sentence), "again")
    assert text_of(again) == text_of(effect.sentence)


BUMP = (FORMER / "fx_bump.txt").read_text()
EDITS = {
    "a line of the module": ("\n\n@dataclass", "\nprint()\n\n@dataclass"),
    "another import": ("import numpy as np", "import os"),
    "a helper of another name": ("import Proposed,", "import os as Proposed,"),
    "a call in a class variable": ('check = "', 'check = print("") or "'),
    "a default that is a call": ("param(0.0", "param(print() or 0.0"),
    "a decorator": ("    def signal", "    @staticmethod\n    def signal"),
    "a default of the method": ("signal: Signal)", "signal: Signal = print())"),
    "a second method": (
        "    def signal",
        "    def size(self):\n        return 1\n\n    def signal",
    ),
    "an annotation": ("start: float", "start: print()"),
    "a base": ("(Proposed)", "(Proposed, metaclass=print)"),
    "a line in the method": ("        change", "        print()\n        change"),
    "another formula": ("np.sin(", "np.cos("),
    "another number": ("0.0, 1.0)", "0.0, 2.0)"),
    "another range": ("bounds=(-2000.0", "bounds=(-9000.0"),
    "another kind": ("    coordinate", '    kind = "tire"\n    coordinate'),
    "no name": ('identifier = "', 'identifier = "A b'),
}


@pytest.mark.parametrize("edit", EDITS)
def test_an_edited_proposal_of_python_needs_consent(edit, tmp_path):
    old, new = EDITS[edit]
    assert old in BUMP
    file = tmp_path / "edited.py"
    file.write_text(BUMP.replace(old, new, 1))
    assert former.sentence_of(file.read_bytes()) is None
    with pytest.raises(consent.ConsentError):
        load_file(file)


def test_a_proposal_that_is_not_of_the_grammar_is_one_line(tmp_path):
    sentence = former.sentence_of(BUMP)
    assert sentence is not None
    good = yaml.safe_load(text_of(sentence))
    cases = {
        "unknown key 'acts'": {"acts": "fx"},
        "'acts_on' is not in the grammar: 'os.system'": {"acts_on": "os.system"},
        "the nearest is 'bump'": {"form": "bumb"},
        "'when' is not in the grammar": {"when": "__import__('os')"},
        "'numbers' must be those of bump: start, length": {"numbers": {"start": 1.0}},
        "'start' is nan": {"numbers": {"start": float("nan"), "length": 1.0}},
        "'within' is": {"within": [1.0, 1.0]},
        "'name' is 3": {"name": 3},
        "is no identifier": {"name": "../evil"},
        "'evidence' is 'x'": {"evidence": "x"},
    }
    for words, change_of in cases.items():
        file = tmp_path / "proposed.yaml"
        file.write_text(yaml.safe_dump(good | change_of))
        with pytest.raises(FlatplankError, match=words) as refused:
            load_file(file)
        assert "\n" not in str(refused.value)
    del good["form"]
    file.write_text(yaml.safe_dump(good))
    with pytest.raises(FlatplankError, match="'form' is missing"):
        load_file(file)


def test_a_moved_campaign_finds_its_files(tmp_path, monkeypatch):
    here, there = tmp_path / "here", tmp_path / "there"
    here.mkdir()
    file = here / "proposed.yaml"
    sentence = former.sentence_of(BUMP)
    assert sentence is not None
    file.write_text(text_of(sentence))
    model = ModelFile(effects=(Entry("proposed", {"amount": 1.0}, str(file)),), campaign=str(here))
    modelfile.save_model(model.with_step("add", "proposed", {}), here / "model.yaml")
    written = yaml.safe_load((here / "model.yaml").read_text())
    assert written["effects"][0]["file"] == "proposed.yaml" and written["campaign"] == "."
    assert written["history"][0]["effects"][0]["file"] == "proposed.yaml"
    shutil.move(here, there)
    found = load_model(there / "model.yaml")
    assert Path(found.effects[0].file).samefile(there / "proposed.yaml")
    assert Path(found.campaign).samefile(there)
    assert Path(found.history[0]["effects"][0]["file"]).samefile(there / "proposed.yaml")


@pytest.mark.parametrize("old", ["absolute", "from here"])
def test_paths_of_earlier_versions_are_found_where_they_exist(old, tmp_path, monkeypatch):
    (tmp_path / "mine.py").write_text(OWN)
    (tmp_path / "campaign").mkdir()
    monkeypatch.chdir(tmp_path)
    write_model(
        tmp_path / "campaign", "mine.py" if old == "from here" else str(tmp_path / "mine.py")
    )
    (entry,) = load_model(tmp_path / "campaign" / "model.yaml").effects
    assert Path(entry.file).samefile(tmp_path / "mine.py")


def test_every_verb_that_loads_effects_can_be_told_to_trust():
    from flatplank_analysis.cli import loop
    from flatplank_control.cli import investigate

    for parser in (loop.loop_parser("x", ""), investigate.parser()):
        told = parser.parse_args(["DIR", "--trust", "a.py", "--effects", "b.py"])
        assert (told.trust, told.effects) == (["a.py"], ["b.py"])
    with pytest.raises(FlatplankError, match="no such file"):
        common.effect_files(told)
