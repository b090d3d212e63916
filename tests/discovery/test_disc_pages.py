# SPDX-License-Identifier: Apache-2.0
"""Every effect has its page, and no page is stale."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest

from flatplank_analysis.cli import effect_pages as pages
from flatplank_analysis.effects.registry import library

FOLDER = Path(__file__).resolve().parents[2] / "docs/reference/effects"
REMEDY = "run: ./flatplank effects --write docs/reference/effects"


@pytest.mark.parametrize("name", sorted(library()))
def test_page_is_there_and_fresh(name):
    effect = library()[name]
    page = FOLDER / f"{name}.md"
    assert page.is_file() and page.read_text(encoding="utf-8") == pages.text_of(effect), REMEDY
    root = ElementTree.parse(FOLDER / f"{name}.svg").getroot()
    assert root.tag.endswith("svg"), REMEDY


def test_index_and_nothing_left_over():
    known = library()
    assert (FOLDER / "README.md").read_text(encoding="utf-8") == pages.index_of(known), REMEDY
    there = {p.stem for p in FOLDER.glob("*.md")} - {"README"}
    assert there == set(known), REMEDY


def test_picture_shows_something():
    text = pages.picture(library()["drive_backlash"])
    assert text.count("<polyline") == len(pages.SLIPS)
    assert "fx [N]" in text
