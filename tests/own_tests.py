# SPDX-License-Identifier: Apache-2.0
"""Which tests are those of a package: what `colcon test` runs in its folder.

A plug-in of pytest for the conftest.py of the packages. A test needs what it imports, and what the
helpers beside it import. It is a test of the package that depends on all others that it needs.
"""

from __future__ import annotations

import ast
import sys
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

TESTS = Path(__file__).resolve().parent
SOURCES = TESTS.parent / "ros_ws" / "src"
PREFIX = "flatplank_"
HELPERS = ("ethercat", "graph")
"""folders whose helpers all tests see, as in pyproject.toml"""
NEED_MORE = ("graph", "env")
"""folders whose tests start nodes or the tools of the repository"""
BROWSER = "pytest.mark.browser"
"""a file with this mark has tests that start nodes and a browser"""


def own_tests(package: str) -> list[Path]:
    """Files of tests that need this package, and no other of ours but those below it; sorted."""
    files = (f for f in TESTS.rglob("test_*.py") if package in needed(f))
    return sorted(f for f in files if needed(f) <= with_those_below(package) and not _more(f))


def _more(file: Path) -> bool:
    """Whether its tests start nodes, a browser or the tools of the repository."""
    return file.parent.name in NEED_MORE or BROWSER in file.read_text(encoding="utf-8")


@cache
def with_those_below(package: str) -> frozenset[str]:
    """A package and those of ours that it depends on."""
    root = ElementTree.parse(SOURCES / package / "package.xml").getroot()
    named = {e.text or "" for e in root if e.tag in ("depend", "exec_depend")}
    below = (with_those_below(name) for name in named if name.startswith(PREFIX))
    return frozenset({package}).union(*below)


@cache
def needed(file: Path) -> frozenset[str]:
    """Our packages that a file and its helpers import."""
    found: set[str] = set()
    waiting, seen = [file, *file.parent.glob("conftest.py")], set()
    while waiting:
        one = waiting.pop()
        if one in seen:
            continue
        seen.add(one)
        for name in _imported(one):
            if name.startswith(PREFIX):
                found.add(name)
            folders = (file.parent, *(TESTS / folder for folder in HELPERS))
            waiting += [p for f in folders if (p := f / f"{name}.py").is_file()]
    return frozenset(found)


def _imported(file: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name.split(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            yield node.module.split(".")[0]


def pytest_configure(config: pytest.Config) -> None:
    """Collect the tests of a package when its folder was asked for as a whole."""
    here = config.invocation_params.dir
    if config.args == [str(here)]:
        config.args = [str(file) for file in own_tests(here.name)]


def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    if exitstatus == pytest.ExitCode.NO_TESTS_COLLECTED:
        session.exitstatus = pytest.ExitCode.TESTS_FAILED  # nothing tested is not green


def pytest_unconfigure(config: pytest.Config) -> None:
    """Where the other tests are; on stderr, which colcon shows."""
    package = config.invocation_params.dir.name
    print(
        f"{len(own_tests(package))} files of tests of {package}; those that need nodes, a browser "
        f"or the whole checkout: ./flatplank test in {TESTS.parent}",
        file=sys.stderr,
    )
