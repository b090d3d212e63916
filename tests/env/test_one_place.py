# SPDX-License-Identifier: Apache-2.0
"""Numbers of the machine stand in one module: no other has them as literals."""

from __future__ import annotations

import ast
import builtins
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from flatplank_data import machine

SOURCES = Path(__file__).resolve().parents[2] / "ros_ws" / "src"
THEIRS = {
    "GEAR_RATIO": (machine.GEAR_RATIO, 30.32),
    "ROAD_LENGTH": (machine.ROAD_LENGTH,),
    "FAST": (machine.FAST,),
    "USUAL_RADIUS": (machine.USUAL_RADIUS,),
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


def test_what_is_near_an_unknown_name_is_found_in_one_place() -> None:
    files = SOURCES.glob("flatplank_*/flatplank_*/**/*.py")
    assert [f.name for f in files if "difflib" in f.read_text(encoding="utf-8")] == ["names.py"]


def test_errors_have_one_root() -> None:
    """Other exceptions are signals within one module, none is told to a user."""
    built_in = {name for name, kind in vars(builtins).items() if _is_exception(kind)}
    own = [
        node.name
        for file in SOURCES.glob("flatplank_*/flatplank_*/**/*.py")
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.ClassDef)
        and node.bases
        and {ast.unparse(base) for base in node.bases} <= built_in
    ]
    signals = ["NotFormerError", "OperatorEnded", "SdoAbort", "_DamageError"]
    assert sorted(own) == sorted(["FlatplankError", *signals])


def _is_exception(kind: object) -> bool:
    return isinstance(kind, type) and issubclass(kind, BaseException)


def test_text_files_are_replaced_in_one_place() -> None:
    """`flatplank_data.files.write_atomic`; tables that are kept are binary files."""
    files = [*SOURCES.glob("flatplank_*/flatplank_*/**/*.py")]
    assert sorted(f.name for f in files if "os.replace(" in f.read_text(encoding="utf-8")) == [
        "files.py",
        "parquet_files.py",
    ]


def test_a_run_is_described_by_one_class() -> None:
    """A plan has what is to be done (`Measurement`), every record and file a `RunRecord`. The
    simulated plant shares nothing with what measures it."""
    said = {"effective_rolling_radius", "step_position", "pressure", "run_index"}
    found = set()
    packages = ("data", "hw", "control", "panel", "analysis")
    files = [f for p in packages for f in SOURCES.glob(f"flatplank_{p}/flatplank_{p}/**/*.py")]
    for file in files:
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ClassDef):
                own = [item.target for item in node.body if isinstance(item, ast.AnnAssign)]
                if said <= {item.id for item in own if isinstance(item, ast.Name)}:
                    found.add(node.name)
    assert found == {"RunRecord", "Measurement"}


def test_bags_and_their_messages_are_read_in_one_way() -> None:
    """By the definition that a message has, in `flatplank_data.bags`; a stamp is where every
    header begins."""
    files = {f: f.read_text(encoding="utf-8") for f in SOURCES.glob("flatplank_*/**/*.py")}
    assert [f.name for f, text in files.items() if "AnyReader" in text] == []
    assert [f.name for f, text in files.items() if "unpack_from(cdr" in text] == ["convert.py"]


def test_yaml_is_read_and_written_in_one_place() -> None:
    """`flatplank_data.yaml_text`, which refuses aliases; a plan's loader keeps the line of each
    key, and a bus file its hexadecimal numbers. What is no YAML is told in one place; a model file
    has its own words."""
    files = {f: f.read_text(encoding="utf-8") for f in SOURCES.glob("flatplank_*/**/*.py")}
    calls = re.compile(r"\byaml\.(safe_load|load|full_load|unsafe_load|safe_dump|dump)\w*\(")
    assert {f.name for f, text in files.items() if calls.search(text)} == {
        "yaml_text.py", "writer.py",
    }  # fmt: skip
    words = {f.name for f, text in files.items() if "not YAML" in text}
    assert words == {"yaml_text.py", "reading.py", "modelfile.py"}
