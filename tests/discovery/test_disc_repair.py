# SPDX-License-Identifier: Apache-2.0
"""A campaign before a repair against one after it."""

from __future__ import annotations

import json
from types import SimpleNamespace

import pytest
from bristles import Truth, campaign, save

from flatplank_analysis.cli.main import main
from flatplank_analysis.contact_patch.repair import change, numbers, text_of
from flatplank_analysis.effects.registry import library
from flatplank_data.errors import FlatplankError

GAP, EFFECT = 9e-4, "drive_backlash"


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """A drive with backlash, and the same without."""
    found = {}
    for seed, (name, gap) in enumerate({"before": GAP, "after": 0.0}.items(), 61):
        truth = Truth(seed=seed, slips=(-0.05, 0.01, 0.05), backlash=gap)
        found[name] = str(save(campaign(truth), tmp_path_factory.mktemp(name)))
    return found


@pytest.fixture(scope="module")
def repaired(folders, tmp_path_factory):
    """What the verb says to programs, and its picture."""
    picture, told = tmp_path_factory.mktemp("picture") / "repair.png", {}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("flatplank_analysis.cli.common.print_json", told.update)
        given = ["repair", folders["before"], folders["after"], EFFECT, "--json"]
        assert main([*given, "--figure", str(picture)]) == 0
    return json.loads(json.dumps(told)), picture


def test_a_repair_that_did_what_the_effect_said(repaired):
    data, picture = repaired
    (effect,) = data["effects"]
    assert effect["before"]["size"] == pytest.approx(GAP, rel=0.15)
    assert effect["change"] == "gone: below the 0.1 mm that matters"
    before, after = data["errors"]["before"], data["errors"]["after"]
    assert before["without"] > 2.0 * before["with"]
    assert after["without"] == pytest.approx(before["with"], rel=0.3)
    slips = [c["condition"].split(",")[0] for c in data["conditions"]]
    assert slips == ["κ -5 %", "κ +1 %", "κ +5 %"]
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_it_is_told_in_words(repaired):
    data, _ = repaired
    text = text_of({**data, "tire": []})
    assert text.startswith(f"{EFFECT}: gone: below the 0.1 mm that matters\n  before 0.")
    assert f"what the effect said: {data['errors']['before']['with']:.1f} N without" in text
    assert "no number left its interval" in text
    moved = {"parameter": "stiff", "unit": "N", "before": 1e5, "after": 9e4}
    assert "slip stiffness 100000 N -> 90000 N" in text_of({**data, "tire": [moved]})


@pytest.mark.parametrize(
    ("size", "reach", "words"),
    [
        (0.02e-3, 0.03e-3, "gone: below the 0.1 mm that matters"),
        (0.04e-3, 0.2e-3, "no longer seen; up to 0.24 mm of it would not be"),
        (0.9e-3, 0.3e-3, "as before"),
        (0.5e-3, 0.1e-3, "less by 50 %"),
        (-0.5e-3, 0.1e-3, "less by 50 %"),
        (2.0e-3, 0.1e-3, "more by 100 %"),
    ],
)
def test_what_became_of_an_effect(size, reach, words):
    """Before 1 mm with an interval of 0.8 to 1.2 mm, of which 0.1 mm matters."""
    before, after = (1e-3, (0.8e-3, 1.2e-3)), (size, (size - reach, size + reach))
    assert change(library()[EFFECT], before, after) == words


def test_what_cannot_be_compared_is_one_line(folders, capsys):
    assert main(["repair", folders["before"], folders["after"]]) == 1
    assert "name what was repaired: EFFECT" in capsys.readouterr().err
    where = SimpleNamespace(campaign=SimpleNamespace(path="mine"))
    one, other = (
        SimpleNamespace(by_condition=lambda n=n: {n: (1.0, 1.0, 1.0)}, session=where)
        for n in ("κ +1 %", "κ +2 %")
    )
    with pytest.raises(FlatplankError, match="mine: .*no condition in common; measure the same"):
        numbers(one, other)
