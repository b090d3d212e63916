# SPDX-License-Identifier: Apache-2.0
"""Every parameter of the base and every verdict is a word of the glossary."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from flatplank_analysis.cli.effect_pages import stage
from flatplank_analysis.cli.main import main
from flatplank_analysis.contact_patch.parameters import NAMES, _parameters
from flatplank_analysis.discovery import verdict
from flatplank_analysis.effects.registry import library
from flatplank_analysis.words import ALL, BASE, COORDINATES, OUTPUTS
from flatplank_validation.pages.glossary import page

PAGE = Path(__file__).resolve().parents[2] / "docs/reference/glossary.md"
VERDICTS = {v for k, v in vars(verdict).items() if k.isupper() and isinstance(v, str)}


def test_every_parameter_of_the_base_has_its_word_and_unit():
    assert set(BASE) == set(NAMES)
    units = {p.name: p.unit for _, p in _parameters(3700.0, turned=True)}
    assert {name: word.unit for name, word in BASE.items()} == units


def test_every_verdict_has_its_word():
    assert len(VERDICTS) >= 6
    assert set(OUTPUTS) >= VERDICTS


def test_every_coordinate_of_an_effect_has_its_word():
    assert {effect.coordinate for effect in library().values()} <= set(COORDINATES)
    assert set(stage().runs.coordinates) == set(COORDINATES)
    assert len(ALL) == len(BASE) + len(COORDINATES) + len(OUTPUTS)


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
    assert set(json.loads(capsys.readouterr().out)) == set(ALL)


def test_another_word_is_one_line_with_the_nearest(capsys):
    assert main(["explain", "patch_oder"]) == 1
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and "the nearest: patch_order" in said


def test_the_page_is_what_the_code_says():
    assert PAGE.read_text(encoding="utf-8") == page()
