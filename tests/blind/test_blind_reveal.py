# SPDX-License-Identifier: Apache-2.0
"""`flatplank reveal`: the answer in words, and files that are no diagnosis."""

from __future__ import annotations

import json

import numpy as np
import pytest

from flatplank_data.campaign import Campaign as Folder
from flatplank_data.errors import FlatplankError
from flatplank_sim.cli import reveal, simulate
from flatplank_sim.sealed import generate
from flatplank_sim.sealed.seal import seal, unseal

PLACE = {"coordinate": "plank position", "range": [2.0, 2.8]}


def _write(folder, **diagnosis):
    (folder / reveal.DIAGNOSIS).write_text(json.dumps({"effects": [], **diagnosis}))


def test_what_is_in_no_library_is_said(tmp_path, capsys):
    seal({"seed": 1, "effects": [], "outside": PLACE}, tmp_path)
    where = [dict(PLACE, range=[2.1, 2.5], share=0.6)]
    _write(tmp_path, verdict="none of these", unexplained={"where": where})
    assert reveal.main([str(tmp_path)]) == 0
    out = capsys.readouterr().out
    assert "outside the library: over the plank position 2 to 2.8 m" in out
    assert "its location was found" in out and "verdict: right" in out
    _write(tmp_path, verdict="none of these", unexplained={"where": []})
    assert reveal.main([str(tmp_path)]) == 1
    out = capsys.readouterr().out
    assert "not found" in out and "verdict: not right" in out


def test_the_form_of_the_force_law_is_no_false_name(tmp_path, capsys):
    seal({"seed": 1, "effects": [], "outside": None}, tmp_path)
    law = {"name": "tire_law", "size": 1.0, "interval": [0.5, 1.5], "class": []}
    _write(tmp_path, verdict="tire law only", effects=[law])
    assert reveal.main([str(tmp_path)]) == 0
    assert "hidden: nothing" in capsys.readouterr().out


def test_a_relative_is_told_and_is_not_right(tmp_path, capsys):
    hidden = {"name": "crosstalk_fz", "size": 0.015, "unit": "1", "class": ["runout_2"]}
    seal({"seed": 1, "effects": [hidden], "outside": None}, tmp_path)
    named = {"name": "runout_2", "size": 3e-4, "unit": "m", "interval": [2e-4, 4e-4], "class": []}
    _write(tmp_path, verdict="found", effects=[named])
    assert reveal.main([str(tmp_path)]) == 1
    out = capsys.readouterr().out
    assert "hidden: crosstalk_fz, 1.5 %\n" in out
    assert "not found: crosstalk_fz; runout_2 was named, a similar effect" in out
    assert "named without cause: runout_2" in out
    assert out.endswith("group: not right\nname: not right\n")


@pytest.mark.parametrize(
    ("name", "others", "told"),
    [
        ("road_play", [], "right"),
        ("road_play", ["rack_backlash"], "open, the group has other members"),
        ("rack_backlash", ["road_play"], "open, the group has other members"),
    ],
)
def test_group_and_name_are_scored_on_two_lines(tmp_path, capsys, name, others, told):
    hidden = {"name": "road_play", "size": 9e-4, "unit": "m", "class": []}
    seal({"seed": 1, "effects": [hidden], "outside": None}, tmp_path)
    named = {"name": name, "size": 9e-4, "unit": "m", "interval": [8e-4, 1e-3], "class": others}
    _write(tmp_path, verdict="found group" if others else "found", effects=[named])
    assert reveal.main([str(tmp_path)]) == 0
    assert capsys.readouterr().out.endswith(f"group: right\nname: {told}\n")


def test_a_group_is_right_and_the_size_of_another_quantity_is_not_judged(tmp_path, capsys):
    hidden = {"name": "crosstalk_fz", "size": 0.015, "unit": "1", "class": []}
    seal({"seed": 1, "effects": [hidden], "outside": None}, tmp_path)
    named = {
        "name": "runout_2", "size": 3e-4, "unit": "m", "interval": [2e-4, 4e-4],
        "class": ["crosstalk_fz"],
    }  # fmt: skip
    _write(tmp_path, verdict="found group", effects=[named])
    assert reveal.main([str(tmp_path)]) == 0
    out = capsys.readouterr().out
    assert "one of the group of runout_2, whose size is another quantity" in out
    assert "%)" not in out
    _write(tmp_path, verdict="found group", effects=[named | {"unit": "1"}])
    assert reveal.main([str(tmp_path)]) == 0
    assert "(-98 %), its interval misses the truth" in capsys.readouterr().out


@pytest.mark.parametrize("text", ["[]", "{}", "{", '{"verdict": "found", "effects": [1]}'])
def test_what_is_no_diagnosis_gets_one_line(tmp_path, text):
    seal({"seed": 1, "effects": [], "outside": None}, tmp_path)
    (tmp_path / reveal.DIAGNOSIS).write_text(text)
    with pytest.raises(ValueError, match=r"diagnosis\.json: .*flatplank diagnose"):
        reveal.main([str(tmp_path)])


def test_a_challenge_with_a_force_outside_the_library(tmp_path, monkeypatch):
    """The same campaign but for the force, which lies where the answer says."""
    monkeypatch.setattr(generate, "SLIPS", (-0.02, 0.02))
    monkeypatch.setattr(generate, "START_ANGLES", {1: 0.0})
    monkeypatch.setattr(generate, "MENU", {"nothing": generate.MENU["nothing"]})
    made = generate.make_challenge(tmp_path / "with", 1, outside="bump")
    plain = generate.make_challenge(tmp_path / "without", 1)
    answer = unseal(made)
    assert answer["effects"] == [] and unseal(plain)["outside"] is None
    low, high = answer["outside"]["range"]
    inside = 0.0
    for one, other in zip(Folder.load(str(made)).runs, Folder.load(str(plain)).runs, strict=True):
        a, b = one.table().columns, other.table().columns
        added = np.abs(a["fx"] - b["fx"])
        at = a["plank_position"]
        assert added[(at < low) | (at > high)].max() == 0.0
        inside = max(inside, float(added.max()))
    assert 59.0 < inside < 121.0


def test_more_runs_are_of_the_same_machine_with_other_noise(tmp_path, monkeypatch):
    monkeypatch.setattr(generate, "SLIPS", (-0.02, 0.02))
    monkeypatch.setattr(generate, "START_ANGLES", {1: 0.0})
    monkeypatch.setattr(generate, "MENU", {"nothing": generate.MENU["nothing"]})
    of = generate.make_challenge(tmp_path / "of", 1, outside="bump")
    generate.make_challenge(tmp_path / "nothing", 1)
    more = [str(tmp_path / "more"), "--more", str(of), "--slips=-2,2", "--starts", "1"]
    assert simulate.main(more) == 0
    assert not (tmp_path / "more" / "answer.sealed").exists()
    fx = {
        (folder, r.info.kappa): r.table().columns["fx"]
        for folder in ("of", "nothing", "more")
        for r in Folder.load(str(tmp_path / folder)).runs
    }
    position = Folder.load(str(of)).runs[0].table().columns["plank_position"]
    low, high = unseal(of)["outside"]["range"]
    inside = (position > low + 0.1) & (position < high - 0.1)
    pulled = []
    for kappa in (-0.02, 0.02):
        again = fx["more", kappa] - fx["of", kappa]
        assert np.std(again) > 5.0, "other noise"
        assert abs(np.mean(again[inside])) < 20.0
        pulled.append(abs(np.mean((fx["more", kappa] - fx["nothing", kappa])[inside])))
    assert max(pulled) > 30.0, "the same force"


def test_more_runs_of_what_is_no_challenge_get_one_line(tmp_path):
    with pytest.raises(FlatplankError, match="nothing is sealed here"):
        simulate.main([str(tmp_path / "more"), "--more", str(tmp_path)])
    seal({"seed": 1, "effects": [], "outside": None}, tmp_path)
    with pytest.raises(FlatplankError, match="make the challenge again"):
        simulate.main([str(tmp_path / "more"), "--more", str(tmp_path)])
    with pytest.raises(ValueError, match="--fz: --more measures the machine of a challenge"):
        simulate.main([str(tmp_path / "more"), "--more", str(tmp_path), "--fz", "3000"])
