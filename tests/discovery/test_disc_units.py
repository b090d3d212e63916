# SPDX-License-Identifier: Apache-2.0
"""Every number that a verb or a page prints has its unit, or is a count or a probability; for the
text of a diagnosis `promises` asks it of every one."""

from __future__ import annotations

import contextlib
import io
import json

import pytest
from bristles import Truth, campaign, save

from bare_numbers import bare_numbers, text_of_page
from flatplank_analysis.cli.main import main
from flatplank_analysis.effects.registry import library
from flatplank_sim.sealed.seal import seal
from flatplank_validation.sweep_sets.brush import BASE, Brush, Plan, sweeps, text_of
from printed_words import unknown_labels

SHARE = "drive_brake_asymmetry"
HIDDEN = {"name": SHARE, "size": 0.1, "unit": "1", "class": []}
PLACE = {"coordinate": "slip level", "range": [-0.05, -0.01], "period": 0.02}
NAMED = {"name": SHARE, "size": 0.09, "interval": [0.08, 0.1], "unit": "1", "class": []}


def said(*words: object) -> str:
    """What a verb prints."""
    text = io.StringIO()
    with contextlib.redirect_stdout(text):
        assert main([str(w) for w in words]) in (0, 1)
    return text.getvalue()


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A campaign in which braking is weaker by a share, with a diagnosis and a sealed answer."""
    there = tmp_path_factory.mktemp("units")
    truth = Truth(seed=31, slips=(-0.05, 0.01, 0.05), repeats=2, asymmetry=0.1, runout=4e-4)
    save(campaign(truth), there)
    seal({"seed": 1, "effects": [HIDDEN], "outside": PLACE}, there)
    (there / "diagnosis.json").write_text(json.dumps({"verdict": "found", "effects": [NAMED]}))
    return there


@pytest.mark.parametrize(
    "words",
    ["table", "compare", f"add {SHARE}", "undo", "reveal"],
)
def test_every_number_that_a_verb_prints_has_its_unit(folder, words):
    told = said(*words.split(), folder)
    assert told and list(bare_numbers(told)) == [], told


def test_every_number_of_a_report_has_its_unit(folder, tmp_path):
    told = said("report", folder, "--out", tmp_path)
    page = text_of_page((tmp_path / "report.html").read_text(encoding="utf-8"))
    assert "Steps as they were" in page
    assert list(bare_numbers(told + page)) == []


def test_every_number_about_sweeps_has_its_unit(tmp_path):
    file = tmp_path / "hot.csv"
    file.write_text(text_of(sweeps(Brush(over_temperature=0.003), Plan(), 1)), encoding="utf-8")
    told = said("sweeps", file, "--tir", BASE) + said("sweeps", file, "--fit", tmp_path / "a.tir")
    assert list(bare_numbers(told)) == [], told


def test_every_number_of_the_glossary_has_its_unit():
    assert list(bare_numbers(said("explain"))) == []


@pytest.mark.parametrize("name", library())
def test_every_number_about_an_effect_has_its_unit(name):
    told = said("effects", name)
    factors = {p.name for p in library()[name].parameters() if p.unit == "-"}
    table = told[told.index("\nparameter ") :].splitlines()
    rows = [line for line in table if line.split()[:1] and line.split()[0] not in factors]
    assert list(bare_numbers("\n".join(rows))) == [], told


@pytest.mark.long
def test_every_number_of_a_page_has_its_unit(folder, tmp_path):
    out = said("diagnose", folder, "--out", tmp_path / "d.json", "--report", tmp_path / "page")
    out += "".join(text_of_page(f.read_text()) for f in (tmp_path / "page").rglob("*.html"))
    assert list(bare_numbers(out)) == [], out


@pytest.mark.long
@pytest.mark.parametrize("words", ["propose {0}", "repair {0} {0} " + SHARE])
def test_every_number_of_a_search_has_its_unit(folder, words):
    told = said(*words.format(folder).split())
    assert told and list(bare_numbers(told)) == unknown_labels(told) == [], told
