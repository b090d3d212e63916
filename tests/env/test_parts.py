# SPDX-License-Identifier: Apache-2.0
"""`flatplank test` in parts that run side by side."""

from __future__ import annotations

import subprocess
import sys
from itertools import chain
from pathlib import Path

import pytest

from flatplank_control.cli import test as verb

TESTS = Path(__file__).parents[1]
SCRIPT = "import sys; from flatplank_control.cli.test import side_by_side;"


def parts_of(monkeypatch: pytest.MonkeyPatch, *argv: str) -> list[list[str]]:
    """What would be run with these options."""
    asked: list[list[str]] = []
    monkeypatch.setattr(verb, "side_by_side", lambda *parts: asked.extend(parts) or 0)
    monkeypatch.setattr(verb.os, "execv", lambda _, words: asked.append(words))
    verb.main(list(argv))
    return asked


@pytest.mark.parametrize("argv", [(), ("-q",), ("--long", "--durations=25")])
def test_every_test_is_in_one_part(monkeypatch, argv):
    here, *beside = parts_of(monkeypatch, *argv)
    ignored = [TESTS.parent / w.removeprefix("--ignore=") for w in here if "--ignore=" in w]
    asked = [TESTS.parent / w for part in beside for w in part if w.startswith("tests/")]
    files = [f for path in asked for f in ([path] if path.is_file() else path.rglob("test_*.py"))]
    assert sorted(files) == sorted(f for folder in ignored for f in folder.rglob("test_*.py"))
    assert all(folder.is_dir() for folder in ignored)
    assert all(set(argv) <= set(part) for part in (here, *beside))


@pytest.mark.parametrize("argv", [("-k", "hub"), ("tests/env",), ("-x",), ("-m", "graph")])
def test_what_is_chosen_runs_in_one_part(monkeypatch, argv):
    assert parts_of(monkeypatch, *argv) == [[*verb.PYTEST, *argv]]


def test_calculations_start_no_nodes():
    for name in chain(*verb.CALCULATIONS):
        for file in (TESTS.parent / name).rglob("test_*.py"):
            marks = [line for line in file.read_text().splitlines() if "pytest.mark.graph" in line]
            assert not marks or "long" in marks[0], file


def run(*parts: str) -> subprocess.CompletedProcess[str]:
    """Parts of Python text."""
    words = [[sys.executable, "-c", text] for text in parts]
    script = f"{SCRIPT} sys.exit(side_by_side(*{words}))"
    return subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )


@pytest.mark.parametrize(
    "codes, expected",
    [((0, 0, 0), 0), ((3, 0, 0), 3), ((0, 4, 0), 4), ((0, 0, 6), 6), ((5, 4, 6), 5)],
)
def test_all_parts_are_shown_and_any_can_fail(codes, expected):
    done = run(
        f"import sys; print('one'); sys.exit({codes[0]})",
        f"import sys; print('two'); sys.exit({codes[1]})",
        f"import sys; print('three'); sys.exit({codes[2]})",
    )
    assert done.returncode == expected, done.stderr
    lines = done.stdout.splitlines()
    shown = ["one", "two", "three"]
    assert [w for w in lines if w in shown] == shown
    assert lines[-1] == ("all parts passed" if expected == 0 else "a part failed, see above")


def test_one_part_beside_the_first_and_two_after_it(tmp_path):
    """Two that meet after the first has ended; the first waits for one of them alone."""
    place = f"here = pathlib.Path({str(tmp_path)!r}); import time;"
    until = (
        "exec('while not (here / NAME).exists(): time.sleep(0.01)'.replace('NAME', repr({!r})))"
    )
    one = f"import pathlib; {place} {until.format('two')}; assert not (here / 'three').exists()"
    one += "; (here / 'ended').touch()"
    two = f"import pathlib; {place} (here / 'two').touch(); {until.format('three')}"
    three = f"import pathlib; {place} assert (here / 'ended').exists(); (here / 'three').touch()"
    done = run(one, two, three)
    assert done.returncode == 0, done.stdout + done.stderr
