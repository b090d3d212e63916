# SPDX-License-Identifier: Apache-2.0
"""`docs/constants.md` has the tuning constants of the search as the code has them."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
BENCHMARKS = ROOT / "validation/benchmarks"


@pytest.fixture(scope="module")
def study():
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(BENCHMARKS)
        import constants

        yield constants
        sys.modules.pop("constants")


def test_the_table_is_that_of_the_code(study):
    text = (ROOT / "docs/constants.md").read_text(encoding="utf-8")
    told = dict(re.findall(r"^\| `([\w.]+)` \| ([^|]+) \|", text, re.M))
    found = {c.key: f"{c.value}" for c in study.constants()}
    assert told == found, "python validation/benchmarks/constants.py --write docs/constants.md"
    assert len(found) > 40


def test_what_is_said_of_constants_is_said_of_constants_that_there_are(study):
    known = {c.key for c in study.constants()}
    assert {*study.SOURCES, *study.FACTS, *study.ABOUT} <= known


@pytest.mark.parametrize(
    ("value", "halved", "doubled"),
    [
        (0.05, 0.025, 0.1),
        (0.8, 0.9, 0.6),
        (5, 2, 10),
        (1, 1, 2),
        ((0.1, 2.0), (0.05, 1.0), (0.2, 4.0)),
    ],
)
def test_how_a_constant_is_halved_and_doubled(study, value, halved, doubled):
    made = study.Constant("discovery.decide", "NONE", value, "")
    for factor, wanted in zip(study.FACTORS, (halved, doubled), strict=True):
        assert made.times(factor) == pytest.approx(wanted)


def test_whoever_imports_a_varied_constant_gets_the_varied_one():
    code = (
        "import constants; constants.vary('discovery.shortlist.EVIDENCE', 2.0);"
        "from flatplank_analysis.discovery import rivals, search, shortlist;"
        "users = [m for m in (rivals, search) if hasattr(m, 'EVIDENCE')];"
        "print(shortlist.EVIDENCE, len(users), *{m.EVIDENCE for m in users})"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=BENCHMARKS, capture_output=True, text=True, check=False
    )
    value, users, *seen = done.stdout.split()
    assert float(value) == 40.0 and int(users) >= 1 and [float(s) for s in seen] == [40.0], done


def test_the_study_tells_what_changed(study):
    (constant, *_) = study.constants()

    def line(key, verdict, right):
        return {"key": key, "verdict": verdict, "names": [], "right": right}

    plain = [line("a", "found", True), line("b", "partly", False)]
    halved = [line("a", "at floor", False), line("b", "partly", False), line("c", "found", True)]
    found = {"": {1.0: plain}, constant.key: {0.5: halved}}
    (row,) = (r for r in study.page(found).splitlines() if f"`{constant.key}`" in r)
    assert row.endswith("| 1 of 2, -1 | - |")
