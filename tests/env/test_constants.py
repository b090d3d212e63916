# SPDX-License-Identifier: Apache-2.0
"""`docs/reference/constants.md` has the tuning constants of the search as the code has them."""

from __future__ import annotations

import json
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
        for name in ("constants", "sensitivity", "branches", "bifurcation", "remembered"):
            sys.modules.pop(name, None)


def test_the_table_is_that_of_the_code(study):
    text = (ROOT / "docs/reference/constants.md").read_text(encoding="utf-8")
    told = dict(re.findall(r"^\| `([\w.]+)` \| ([^|]+) \|", text, re.M))
    found = {c.key: f"{c.value}" for c in study.constants()}
    assert told == found, (
        "python validation/benchmarks/constants.py --write docs/reference/constants.md"
    )
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
    made = study.Constant("inference.posterior", "NONE", value, "")
    for factor, wanted in zip(study.FACTORS, (halved, doubled), strict=True):
        assert made.times(factor) == pytest.approx(wanted)


def test_whoever_imports_a_varied_constant_gets_the_varied_one():
    code = (
        "import sensitivity;"
        "others = {'inference.posterior.MEMBER': 0.1, 'inference.priors.USUAL': 4.0};"
        "sensitivity.vary(others);"
        "from flatplank_analysis.inference import answer, explore, nextrun, posterior, priors;"
        "users = [m for m in (answer, explore, nextrun) if hasattr(m, 'MEMBER')];"
        "print(priors.USUAL, len(users), *{m.MEMBER for m in (posterior, *users)})"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=BENCHMARKS, capture_output=True, text=True, check=False
    )
    value, users, *seen = done.stdout.split()
    assert float(value) == 4.0 and int(users) >= 1 and [float(s) for s in seen] == [0.1], done


def test_the_study_tells_what_changed(study, tmp_path):
    (constant, *_) = study.constants()

    def line(of, factor, key, verdict, right, value=constant.value, code="one"):
        return {
            "constant": of, "factor": factor, "value": str(value), "code": code, "key": key,
            "verdict": verdict, "names": [], "right": right,
        }  # fmt: skip

    lines = [
        line("", 1.0, "a", "found", True), line("", 1.0, "b", "partly", False),
        line(constant.key, 0.5, "a", "at floor", False),
        line(constant.key, 0.5, "b", "partly", False),
        line(constant.key, 0.5, "c", "found", True),
        line(constant.key, 0.5, "b", "found", True, code="other"),
        line(constant.key, 2.0, "b", "found", True, value=-1.0),
    ]  # fmt: skip
    journal = tmp_path / "journal.jsonl.gz"
    study.publish([*lines, lines[2]], journal)
    assert len(study.read(journal)) == len(lines) and not study.read(tmp_path / "none")
    text = study.page(study.sorted_out([*study.read(journal), *lines]))
    (row,) = (r for r in text.splitlines() if f"`{constant.key}`" in r)
    assert row.endswith("| 1 of 2, -1 | - |")


SIZES = "SMALL, LARGE, UNUSED, EARLY = 2, 3, 5, 7\nTWICE = 2 * EARLY\n"
SUM = """
from package import sizes
from package.sizes import SMALL as LEAST

begun = []

def first():
    begun.append("first")
    return sizes.LARGE

def second():
    begun.append("second")
    return LEAST

def total():
    begun.clear()
    return 100 * first() + second(), len(begun)
"""
STUDY = """
import json, pathlib, sys
from branches import Package, run
from package.sums import total

package = Package(pathlib.Path(sys.argv[1]))
small, large, unused, early = (
    package.names_of("package.sizes", n) for n in ("SMALL", "LARGE", "UNUSED", "EARLY")
)
branches = [[(small, 9)], [(large, 9)], [(unused, 9)], [(small, 8), (large, 7)]]
print(json.dumps([*run(total, branches), [n.at_import for n in (small, large, unused, early)]]))
"""


def test_what_precedes_the_first_use_of_a_constant_is_done_once(tmp_path):
    """SMALL is read last, by another name; nobody reads UNUSED; EARLY is read at the import."""
    folder = tmp_path / "package"
    folder.mkdir()
    for name, text in (("__init__", ""), ("sizes", SIZES), ("sums", SUM)):
        (folder / f"{name}.py").write_text(text, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", STUDY, str(folder)], check=True, capture_output=True, text=True,
        env={"PYTHONPATH": f"{tmp_path}:{BENCHMARKS}"},
    )  # fmt: skip
    plain, branches, early = json.loads(done.stdout)
    assert plain == [302, 2] and early == [False, False, False, True]
    assert branches == [[309, 2], [902, 2], None, [708, 2]]


def test_settings_that_change_something_are_found_in_groups(study):
    from bifurcation import bifurcate, groups_of

    asked = []

    def answers_of(groups):
        asked.extend(groups)
        return [sum(i in (3, 11) for i in group) for group in groups]

    told = list(bifurcate(groups_of(range(20), 8), answers_of, bool))
    assert sorted(item for item, _, _ in told) == list(range(20))
    assert {item for item, answer, _ in told if answer} == {3, 11}
    assert {count for _, answer, count in told if answer} == {1}
    assert len(asked) == 3 + 2 * 2 * 3 and [len(g) for g in asked[:3]] == [8, 8, 4]
