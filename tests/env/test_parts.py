# SPDX-License-Identifier: Apache-2.0
"""`flatplank test` in two parts that run side by side."""

from __future__ import annotations

import subprocess
import sys
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
    here, beside = parts_of(monkeypatch, *argv)
    ignored = [w.removeprefix("--ignore=tests/") for w in here if w.startswith("--ignore")]
    assert ignored == [w.removeprefix("tests/") for w in beside if w.startswith("tests/")]
    assert all((TESTS / name).is_dir() for name in ignored)
    assert set(argv) <= set(here) and set(argv) <= set(beside)


@pytest.mark.parametrize("argv", [("-k", "hub"), ("tests/env",), ("-x",), ("-m", "graph")])
def test_what_is_chosen_runs_in_one_part(monkeypatch, argv):
    assert parts_of(monkeypatch, *argv) == [[*verb.PYTEST, *argv]]


def test_calculations_start_no_nodes():
    for name in verb.CALCULATIONS:
        for file in (TESTS / name).rglob("test_*.py"):
            marks = [line for line in file.read_text().splitlines() if "pytest.mark.graph" in line]
            assert not marks or "long" in marks[0], file


def run(first: str, second: str) -> subprocess.CompletedProcess[str]:
    """Two parts of Python text."""
    words = [[sys.executable, "-c", text] for text in (first, second)]
    script = f"{SCRIPT} sys.exit(side_by_side({words[0]}, {words[1]}))"
    return subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )


@pytest.mark.parametrize("codes, expected", [((0, 0), 0), ((3, 0), 3), ((0, 4), 4), ((5, 4), 5)])
def test_both_parts_are_shown_and_either_can_fail(codes, expected):
    done = run(
        f"import sys; print('one'); sys.exit({codes[0]})",
        f"import sys, os; print('two', os.nice(0)); sys.exit({codes[1]})",
    )
    assert done.returncode == expected, done.stderr
    lines = done.stdout.splitlines()
    assert [w for w in ("one", "two 10") if w in lines] == ["one", "two 10"]
    assert lines[-1] == ("both parts passed" if expected == 0 else "a part failed, see above")
