# SPDX-License-Identifier: Apache-2.0
"""What the documents link to is there, and what the tour names stands in the file it links to."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "examples").glob("*.md")]
LINK = re.compile(r"\]\(([^)\s]+)\)")
STATION = re.compile(r"`(\w+)` in\s+\[[^]]+\]\(([^)]+)\)")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_to_files(page: Path) -> None:
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    targets = [
        t for t in LINK.findall(text) if not t.startswith(("http:", "https:", "#", "mailto:"))
    ]
    missing = [t for t in targets if not (page.parent / t.split("#")[0]).exists()]
    assert not missing


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_into_pages_lead_to_headings(page: Path) -> None:
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    split = [t.partition("#") for t in LINK.findall(text) if not t.startswith("http")]
    marks = [(page.parent / t if t else page, mark) for t, _, mark in split if mark]
    lost = [m for target, m in marks if target.suffix == ".md" and m not in _headings(target)]
    assert not lost


def _headings(page: Path) -> set[str]:
    """Marks of the headings as GitHub and the site make them."""
    heads = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", h.lower()).replace(" ", "-") for h in heads}


def test_the_tour_names_what_is_in_its_files() -> None:
    page = ROOT / "docs/explanation/tour.md"
    stations = STATION.findall(page.read_text(encoding="utf-8"))
    assert len(stations) == 11
    for name, link in stations:
        code = (page.parent / link).read_text(encoding="utf-8")
        assert re.search(rf"\b(def|class) {name}\b", code), f"{name} is not in {link}"


def test_nothing_rests_on_a_page_that_is_not_here():
    """Numbered sections in capitals were pages of the design; a user has none of them."""
    cited = re.compile(r"\b(DISCOVERY|PROPOSE|REFERENCE|HOUSE|DESIGN)( section)? \d")
    folders = ("ros_ws/src", "validation", "examples", "docs")
    files = [p for f in folders for ext in ("py", "md") for p in (ROOT / f).rglob(f"*.{ext}")]
    assert len(files) > 500
    assert [str(p) for p in files if cited.search(p.read_text(encoding="utf-8"))] == []
