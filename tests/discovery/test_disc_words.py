# SPDX-License-Identifier: Apache-2.0
"""Every parameter of the base and every verdict is a word of the glossary."""

from __future__ import annotations

import html
import json
import re
from pathlib import Path

import pytest
from bristles import Truth, campaign, save

import flatplank_analysis
from flatplank_analysis.cli.effect_pages import stage
from flatplank_analysis.cli.main import main
from flatplank_analysis.column_words import COLUMNS, SWEEPS
from flatplank_analysis.contact_patch.parameters import NAMES, _parameters
from flatplank_analysis.discovery import verdict
from flatplank_analysis.discovery.opening import opened
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

PAGE = Path(__file__).resolve().parents[2] / "docs/reference/glossary.md"
PAGES = Path(flatplank_analysis.__file__).parent
HEADER = re.compile(r"<th\b[^>]*>([^<]+)</th>")
LEVEL = re.compile(r"[+-]?\d+ %")
"""column of a slip level"""
VERDICTS = {v for k, v in vars(verdict).items() if k.isupper() and isinstance(v, str)}


def test_every_parameter_of_the_base_has_its_word_and_unit():
    assert set(BASE) == set(NAMES)
    units = {p.name: p.unit for _, p in _parameters(3700.0, turned=True)}
    assert {name: word.unit for name, word in BASE.items()} == units


def test_every_word_has_title_and_sentence():
    assert [n for n, w in ALL.items() if not w.title or not w.sentence.endswith(".")] == []


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
    columns = headers_of(capsys.readouterr().out)
    assert {"BCD [N/deg]", "off most", "remark"} <= set(columns)
    assert [name for name in [*names, *columns] if not known(name)] == []


def test_every_column_of_a_campaign_has_its_word(tmp_path, capsys):
    folder = save(campaign(Truth(seed=31, slips=(-0.05, 0.01, 0.05), repeats=2)), tmp_path)
    for words in (["table"], ["compare"], ["add", "rolling_resistance"]):
        assert main([*words, str(folder)]) == 0
    assert main(["report", str(folder), "--out", str(tmp_path / "report")]) == 0
    columns = headers_of(capsys.readouterr().out)
    pages = [PAGES / "discovery/report/diagnosis.html.j2", tmp_path / "report/report.html"]
    for page_of in pages:
        columns += map(html.unescape, HEADER.findall(page_of.read_text(encoding="utf-8")))
    assert {"error [floors]", "kappa [%]", "κ before [%]", "why"} <= set(columns)
    assert [n for n in columns if not known(n) and not LEVEL.fullmatch(n)] == []


def headers_of(text: str) -> list[str]:
    """Cells of the lines that begin a table: three columns or more, above a line of such."""
    lines = [re.split(r"\s{2,}", line.strip()) for line in text.splitlines()]
    above = [[], *lines]
    return [
        cell
        for before, line, row in zip(above, lines, lines[1:], strict=False)
        if len(before) < 3 <= min(len(line), len(row))
        for cell in line
    ]


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
    assert set(json.loads(capsys.readouterr().out)) == set(ALL)


def test_another_word_is_one_line_with_the_nearest(capsys):
    assert main(["explain", "patch_oder"]) == 1
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and "the nearest: patch_order" in said


def test_the_page_is_what_the_code_says():
    assert PAGE.read_text(encoding="utf-8") == page()
