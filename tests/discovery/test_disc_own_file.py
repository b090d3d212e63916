# SPDX-License-Identifier: Apache-2.0
"""An effect of one's own: a file from a few answers, and what it would remove."""

from __future__ import annotations

import json

import numpy as np
import pytest
from bristles import Truth, campaign, save

from flatplank_analysis.cli import effects
from flatplank_analysis.cli.new_effect import TARGETS
from flatplank_analysis.effects import consent
from flatplank_data.errors import FlatplankError


@pytest.mark.parametrize("target", TARGETS)
def test_a_new_file_passes_the_contract(target, tmp_path, capsys):
    file = tmp_path / "mine.py"
    line = ["new", "hall_draught", "--changes", target, "--over", "plank position"]
    assert effects.main([*line, "--title", 'a "draught"', "--out", str(file)]) == 0
    assert f"effects try {file} DIR" in capsys.readouterr().out
    assert effects.main(["check", str(file), "--trust", str(file)]) == 0
    assert capsys.readouterr().out == "hall_draught: passes the contract\n"


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["new", "Hall"], "'Hall' is no name"),
        (["new", "class"], "'class' is a word of Python"),
        (["new", "mine", "--changes", "lod"], "unknown target 'lod'.*load"),
        (["new", "mine", "--over", "plank positon"], "unknown coordinate.*plank position"),
    ],
)
def test_a_wrong_answer_is_one_line_and_no_file(words, told, tmp_path):
    with pytest.raises(FlatplankError, match=told):
        effects.main([*words, "--out", str(tmp_path / "mine.py")])
    assert not list(tmp_path.iterdir())


def test_a_file_that_is_there_stays(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text("precious")
    with pytest.raises(FlatplankError, match="is there already"):
        effects.main(["new", "mine", "--out", str(file)])
    assert file.read_text() == "precious"


def test_try_tells_what_an_effect_would_remove_and_writes_nothing(tmp_path, capsys):
    """A force along the plank of 60 N from end to end, in all runs."""
    tables = campaign(Truth(seed=43, slips=(-0.05, -0.01, 0.01, 0.05), repeats=2))
    pulled = []
    for table in tables:
        x = table["plank_position"]
        pulled.append(table.with_columns(fx=table["fx"] + 60.0 * (x - x.mean()) / np.ptp(x)))
    (tmp_path / "campaign").mkdir()
    folder = save(pulled, tmp_path / "campaign")
    before = sorted(folder.rglob("*"))
    file = tmp_path / "pull.py"
    effects.main(["new", "pull", "--out", str(file)])
    capsys.readouterr()
    consent.give([file])
    assert effects.main(["try", str(file), str(folder), "--json"]) == 0
    (found,) = json.loads(capsys.readouterr().out).values()
    assert found["rmse"] < 0.8 * found["rmse_before"]
    assert found["size"] == pytest.approx(60.0, abs=15.0)
    assert effects.main(["try", str(file), str(folder)]) == 0
    assert capsys.readouterr().out.startswith("pull: ")
    assert sorted(folder.rglob("*")) == before


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("def signal(", "def signl(", "'signl' is no hook; the hooks are motion, tire, node, sig"),
        ("amount", "size", "size: a hook has this name"),
    ],
)
def test_a_misspelt_hook_and_a_hidden_one_are_named(old, new, told, tmp_path, capsys):
    file = tmp_path / "mine.py"
    effects.main(["new", "mine", "--out", str(file)])
    file.write_text(file.read_text().replace(old, new))
    capsys.readouterr()
    assert effects.main(["check", str(file), "--trust", str(file)]) == 1
    assert told in capsys.readouterr().out
