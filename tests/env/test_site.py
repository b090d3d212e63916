# SPDX-License-Identifier: Apache-2.0
"""The documentation site holds every page once, and its reference everything that is offered."""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path

import pytest

import flatplank_analysis as fp

ROOT = Path(__file__).parents[2]
SITE = ROOT / "docs" / "site"
ENTRY = re.compile(r"^   (/\S+)$", re.MULTILINE)
AUTO = re.compile(r"^\.\. auto\w+:: (\S+)$", re.MULTILINE)


def test_every_page_is_in_the_contents_once() -> None:
    entries = ENTRY.findall((SITE / "index.rst").read_text(encoding="utf-8"))
    pages = [p for e in entries for p in sorted(ROOT.glob(f"{e[1:]}.md"))]
    own = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), ROOT / "examples" / "README.md"]
    assert len(pages) == len(set(pages)) and set(pages) == set(own)
    assert not list(SITE.glob("*.md")), "pages lie in docs/, the site is made of them"


def test_the_reference_has_what_the_package_offers_and_every_docstring() -> None:
    told = AUTO.findall((SITE / "reference.rst").read_text(encoding="utf-8"))
    assert set(fp.__all__) <= {name.rpartition(".")[2] for name in told}
    for name in told:
        module, _, thing = name.rpartition(".")
        assert getattr(import_module(module), thing).__doc__, name


@pytest.mark.parametrize("name", ["site", "rivals", "audit"])
def test_what_few_need_is_pinned_and_no_part_of_the_environment(name) -> None:
    pinned = (ROOT / "requirements" / f"{name}.txt").read_text(encoding="utf-8")
    names = set(re.findall(r"(?m)^([\w-]+)==", pinned.lower()))
    asked = (ROOT / "requirements" / f"{name}.in").read_text(encoding="utf-8").splitlines()
    assert {line for line in asked if not line.startswith("#")} <= names
    lock = (ROOT / "requirements" / "lock.txt").read_text(encoding="utf-8")
    assert not re.search(r"^(sphinx|furo|myst-parser|pyoperon|pip-audit)==", lock, re.MULTILINE)
