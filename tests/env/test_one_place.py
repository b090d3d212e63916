# SPDX-License-Identifier: Apache-2.0
"""Numbers of the machine stand in one module: no other has them as literals."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

from flatplank_data import machine

SOURCES = Path(__file__).resolve().parents[2] / "ros_ws" / "src"
THEIRS = {
    "GEAR_RATIO": (machine.GEAR_RATIO, 30.32),
    "ROAD_LENGTH": (machine.ROAD_LENGTH,),
    "FAST": (machine.FAST,),
}
"""constant -> literals that are its value, or a part of it"""


def literals(file: Path) -> Iterator[float]:
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Constant) and isinstance(node.value, float):
            yield node.value


@pytest.mark.parametrize("name", THEIRS)
def test_a_number_of_the_machine_stands_once(name: str) -> None:
    files = [file for file in SOURCES.glob("flatplank_*/flatplank_*/**/*.py")]
    having = [file for file in files if not set(THEIRS[name]).isdisjoint(literals(file))]
    assert [file.relative_to(SOURCES).as_posix() for file in having] == [
        "flatplank_data/flatplank_data/machine.py"
    ]


def test_one_hint_names_what_is_near_an_unknown_name() -> None:
    """`flatplank_data.params.nearest`; the analysis and its readers have words of their own."""
    packages = ("hw", "control", "sim", "panel")
    files = [f for p in packages for f in SOURCES.glob(f"flatplank_{p}/flatplank_{p}/**/*.py")]
    assert files
    assert [f.name for f in files if "difflib" in f.read_text(encoding="utf-8")] == []
