# SPDX-License-Identifier: Apache-2.0
"""Of small faults in search, effects, models, fits and bench nine of ten are noticed by a
test."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import mutate
import pytest
from lines import VARIABLE, Lines
from mutants import mutants_of

CODE = '''
LIMIT = 3.0

def f(x, n=2):
    """Twice 2."""
    if n > 1 and x:
        g(x + 1.0)
    return -abs(x) * 0 / max(float(x), 1e-30)
'''


def test_faults_are_made_one_at_a_time(tmp_path):
    path = tmp_path / "code.py"
    path.write_text(CODE)
    made = [(m.old, m.new) for m in mutants_of(path, "code.py")]
    assert made == [
        ("n > 1 and x", "(n > 1 or x)"), ("n > 1", "(n < 1)"), ("1", "(2)"),
        ("g(x + 1.0)", "pass"), ("x + 1.0", "(x - 1.0)"), ("1.0", "(2.0)"),
        ("-abs(x) * 0 / max(float(x), 1e-30)", "(-abs(x) * 0 * max(float(x), 1e-30))"),
        ("-abs(x) * 0", "(-abs(x) / 0)"), ("-abs(x)", "(abs(x))"),
        ("abs(x)", "(x)"), ("0", "(1)"),
    ]  # fmt: skip
    for mutant in mutants_of(path, "code.py"):
        ast.parse(mutant.source)
        assert mutant.source != CODE


TESTS = """
import pytest
from code_ import f, g

@pytest.fixture(scope="module")
def made():
    return g()

def test_one():
    assert f(1)

def test_two(made):
    assert made
"""


def test_lines_of_a_statement_and_the_tests_that_run_them(tmp_path, monkeypatch):
    (tmp_path / "top").mkdir()
    code = tmp_path / "top" / "code_.py"
    code.write_text(
        "def f(x):\n    if x > 5:\n        return 1\n    return abs(\n        x + 1)\n\n"
        "def g():\n    return 4\n"
    )
    places = {m.old: m.lines for m in mutants_of(code, "code_.py")}
    assert places == {"x > 5": (2,), "5": (2,), "abs(\n        x + 1)": (4, 5),
                      "x + 1": (4, 5), "1": (4, 5), "4": (8,)}  # fmt: skip
    (tmp_path / "test_it.py").write_text(TESTS)
    monkeypatch.setenv(VARIABLE, f"{tmp_path / 'top'}:{tmp_path / 'out.json'}")
    monkeypatch.setenv("PYTHONPATH", f"{Path(__file__).parent}:{tmp_path / 'top'}")
    words = [sys.executable, "-m", "pytest", "-q", "-p", "lines", "--rootdir", str(tmp_path)]
    done = subprocess.run([*words, "test_it.py"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    found = Lines.read(tmp_path / "out.json")
    assert found.of("code_.py", (4, 5)) == ("test_it.py::test_one",)
    assert found.of("code_.py", (3,)) == ()
    assert "test_it.py::test_two" in found.of("code_.py", (8,))


@pytest.mark.parametrize("area", mutate.AREAS, ids=lambda a: a.name)
def test_a_sample_is_fair_and_can_be_repeated(area):
    for tests in area.tests:
        assert (mutate.ROOT / tests).exists(), tests
    one, two = (list(mutate.sample([area], 30, seed)) for seed in (1, 1))
    assert [m.name for _, m in one] == [m.name for _, m in two]
    assert len({m.source for _, m in one}) == 30
    files = {m.file for m in mutate.all_of(area)}
    assert len({m.file for _, m in one}) == min(len(files), 30)


NAMED = {
    "Fz of -9000 N counts as unloaded": (
        "drive", "drive/safety.py", "-p.unloaded_fz < s.fz < p.unloaded_fz",
        "s.fz < p.unloaded_fz", "tests/drive/test_drive_rules.py",
    ),
    "a reference that is no number counts": (
        "drive", "drive/axis.py", "reason = self._mode.refusal(reference.value)",
        'reason = ""', "tests/drive/test_drive_gate.py",
    ),
    "a reference from before the enabling counts": (
        "drive", "drive/axis.py",
        "self._reference, self._asked_at = 0, None, self._stamp",
        "self._reference, self._asked_at = 0, self._reference, self._stamp",
        "tests/drive/test_drive_gate.py",
    ),
    "the start torque is added twice": (
        "free_rolling", "free_rolling/controller.py", "wanted = lead + p.start_torque",
        "wanted = lead + 2.0 * p.start_torque", "tests/control/test_control_free_rolling.py",
    ),
    "a page of another port of this machine is let in": (
        "panel", "access.py", 'urlsplit(origin).netloc != headers.get("host", "")',
        "urlsplit(origin).hostname != host", "tests/panel/test_panel_access.py",
    ),
}  # fmt: skip
"""what goes wrong -> area, file, code, faulty code, tests that must notice it"""


@pytest.mark.long
@pytest.mark.parametrize("name", NAMED)
def test_a_fault_that_would_be_dangerous_is_noticed(name, tmp_path):
    area, file, old, new, tests = NAMED[name]
    (chosen,) = [a for a in mutate.AREAS if a.name == area]
    copied = mutate.Copy(tmp_path, [chosen])
    assert copied.first_failure([tests], 600.0) == ""
    path = tmp_path / chosen.package / file
    text = path.read_text()
    assert text.count(old) == 1
    path.write_text(text.replace(old, new))
    assert copied.first_failure([tests], 600.0) not in ("", "too slow")


@pytest.mark.long
@pytest.mark.timeout(3 * 3600)
def test_nine_of_ten_faults_are_noticed():
    count = 12 * len(mutate.AREAS)
    results = mutate.run(mutate.AREAS, count, 1, 2.5 * 3600.0)
    print(mutate.summary(results))
    assert len(results) == count
    assert mutate.share(results) >= 0.9, mutate.summary(results)
