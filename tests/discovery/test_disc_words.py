# SPDX-License-Identifier: Apache-2.0
"""Every parameter of the base and every verdict is a word of the glossary."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from bristles import Truth, campaign, save

from flatplank_analysis import effect_words
from flatplank_analysis.cli.effect_pages import stage
from flatplank_analysis.cli.main import main
from flatplank_analysis.column_words import COLUMNS, SWEEPS
from flatplank_analysis.contact_patch.parameters import NAMES, _parameters
from flatplank_analysis.discovery import verdict
from flatplank_analysis.discovery.opening import opened
from flatplank_analysis.effects.grammar.parameter_words import WORDS
from flatplank_analysis.effects.grammar.shapes import shapes
from flatplank_analysis.effects.registry import library
from flatplank_analysis.slip_sweeps.effects import effects as effects_of_sweeps
from flatplank_analysis.slip_sweeps.model import sweep_model
from flatplank_analysis.slip_sweeps.study import study
from flatplank_analysis.words import ALL, BASE, COORDINATES, OUTPUTS, known
from flatplank_tire import read_tir
from flatplank_tire.magic_formula.coefficients import SECTION_OF
from flatplank_validation.pages.glossary import page
from flatplank_validation.sweep_sets.brush import BASE as TIRE_FILE
from flatplank_validation.sweep_sets.brush import Brush, Plan, sweeps, text_of
from printed_words import headers_of, unknown_headers, unknown_in_page

PAGE = Path(__file__).resolve().parents[2] / "docs/reference/glossary.md"
VERDICTS = {v for k, v in vars(verdict).items() if k.isupper() and isinstance(v, str)}


def test_every_parameter_of_the_base_has_its_word_and_unit():
    assert set(BASE) == set(NAMES)
    units = {p.name: p.unit for _, p in _parameters(3700.0, turned=True)}
    assert {name: word.unit for name, word in BASE.items()} == units


def test_every_word_has_title_and_sentence():
    assert [n for n, w in ALL.items() if not w.title or not w.sentence.endswith(".")] == []


def test_every_parameter_of_every_effect_has_symbol_title_unit_and_sentence():
    for effect in [*library().values(), *effects_of_sweeps()]:
        for p in effect.parameters():
            word = p.word
            where = f"{effect.identifier}.{p.name}"
            assert all((word.symbol, word.title, word.unit)), where
            assert word.sentence.endswith(".") and not word.sentence[0].islower(), where


def test_every_parameter_of_a_proposal_has_its_word():
    names = {n for s in shapes().values() for n in (*s.sizes, *(k.name for k in s.numbers))}
    assert names == set(WORDS)
    assert all(w.symbol and w.title and w.sentence.endswith(".") for w in WORDS.values())


def test_a_parameter_of_an_effect_is_explained_with_and_without_its_effect(capsys):
    for told in ("rack_backlash.held_fast", "held_fast"):
        assert main(["explain", told]) == 0
        said = capsys.readouterr().out
        assert said.startswith("rack_backlash.held_fast: held plank (b_h). 1: the friction")
    assert main(["explain", "time"]) == 0
    assert {"time", "carcass_creep.time"} == {
        line.partition(":")[0] for line in capsys.readouterr().out.splitlines()
    }
    assert main(["explain", "rack_backlash"]) == 0
    assert "held_fast: held plank (b_h). 1: the friction" in capsys.readouterr().out


def test_every_effect_is_explained_by_its_name(capsys):
    for name in [*library(), *(effect.identifier for effect in effects_of_sweeps())]:
        assert main(["explain", name]) == 0
        assert name in capsys.readouterr().out


def test_every_coefficient_of_a_tire_file_has_its_word():
    assert [name for name in SECTION_OF if not known(name)] == []
    assert known("PDX1").title == "peak of Fx, coefficient 1"


def test_every_parameter_and_column_of_sweeps_has_its_word(tmp_path, capsys):
    file = tmp_path / "hot.csv"
    file.write_text(text_of(sweeps(Brush(over_temperature=0.003), Plan(), 1)), encoding="utf-8")
    model = opened(sweep_model([study(str(file))], read_tir(TIRE_FILE)))
    names = [*(p.name for p in model.parameters), *model.runs.coordinates]
    assert main(["sweeps", str(file), "--tir", str(TIRE_FILE)]) == 0
    assert main(["sweeps", str(file), "--fit", str(tmp_path / "own.tir")]) == 0
    printed = capsys.readouterr().out
    assert {"BCD [N/deg]", "off most", "remark"} <= set(headers_of(printed))
    assert [name for name in names if not known(name)] == unknown_headers(printed) == []


def test_every_column_of_a_campaign_has_its_word(tmp_path, capsys):
    folder = save(campaign(Truth(seed=31, slips=(-0.05, 0.01, 0.05), repeats=2)), tmp_path)
    for words in (["table"], ["compare"], ["add", "rolling_resistance"]):
        assert main([*words, str(folder)]) == 0
    assert main(["report", str(folder), "--out", str(tmp_path / "report")]) == 0
    printed = capsys.readouterr().out
    assert {"error [floors]", "kappa [%]"} <= set(headers_of(printed))
    assert unknown_headers(printed) == []
    made = (tmp_path / "report/report.html").read_text(encoding="utf-8")
    assert ">κ before [%]</abbr>" in made and unknown_in_page(made) == []


def test_every_verdict_has_its_word():
    assert len(VERDICTS) >= 6
    assert set(OUTPUTS) >= VERDICTS


def test_every_coordinate_of_an_effect_has_its_word():
    assert {effect.coordinate for effect in library().values()} <= set(COORDINATES)
    assert set(stage().runs.coordinates) == set(COORDINATES)
    assert len(ALL) == sum(map(len, (BASE, COORDINATES, OUTPUTS, COLUMNS, SWEEPS)))


@pytest.mark.parametrize(
    ("word", "told"),
    [
        ("patch_order", "patch_order: memory of the patch. How the force"),
        ("carcass", "carcass: carcass stiffness (C_cx, in N/m). Stiffness"),
        ("at floor", "at floor: Verdict: nothing of consequence is missing."),
        ("road_play", "road_play: Play of the road in x"),
    ],
)
def test_a_word_is_explained(word, told, capsys):
    assert main(["explain", *word.split()]) == 0
    assert capsys.readouterr().out.startswith(told)


def test_the_glossary_is_json_too(capsys):
    assert main(["explain", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert set(told) == {*ALL, *effect_words.parameters()}
    assert told["worn_patch.depth"]["unit"] == "1"


def test_another_word_is_one_line_with_the_nearest(capsys):
    assert main(["explain", "patch_oder"]) == 1
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and "the nearest: patch_order" in said
    assert main(["explain", "held_fats"]) == 1
    assert "the nearest: held_fast" in capsys.readouterr().err


def test_the_page_is_what_the_code_says():
    assert PAGE.read_text(encoding="utf-8") == page()
