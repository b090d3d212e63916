# SPDX-License-Identifier: Apache-2.0
"""The set-up of a checkout: its own failures are one line, and a copied folder does not break."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import pytest
from colcon_core.verb import check_and_mark_build_tool, check_and_mark_install_layout

ROOT = Path(__file__).resolve().parents[2]
LEFT_OUT = (".venv", ".cache", ".git", "build", "install", "log", "demo", "__pycache__")


@pytest.fixture
def copied(tmp_path: Path) -> Path:
    """The checkout without what the set-up has made."""
    copy = tmp_path / "copy"
    shutil.copytree(ROOT, copy, ignore=shutil.ignore_patterns(*LEFT_OUT, ".*_cache", "docs"))
    return copy


def start(folder: Path, *arguments: str, **variables: str) -> subprocess.CompletedProcess:
    env = {k: v for k, v in os.environ.items() if not k.startswith(("PIP_", "UV_"))} | variables
    return subprocess.run(
        [folder / "flatplank", *arguments], capture_output=True, text=True, env=env, timeout=280
    )


def failed_in_one_line(done: subprocess.CompletedProcess) -> str:
    """The last line of a set-up that failed; what is before it is progress."""
    assert done.returncode == 1, done.stderr
    assert "Traceback" not in done.stderr
    lines = done.stderr.strip().splitlines()
    assert all(line.startswith("flatplank: ") for line in lines)
    return lines[-1]


def venv_of_another_folder(folder: Path) -> Path:
    """A .venv as it comes with a copied folder: its own Python, another folder's stamp."""
    venv = folder / ".venv"
    (venv / "bin").mkdir(parents=True)
    (venv / "bin" / "python").symlink_to(os.path.realpath(sys.executable))
    (venv / "flatplank.begun").write_text("of another folder")
    return venv


NOTHING_TO_REACH = {"PIP_INDEX_URL": "http://127.0.0.1:9/", "PIP_RETRIES": "0",
                    "PIP_CONFIG_FILE": os.devnull, "PIP_NO_CACHE_DIR": "1"}  # fmt: skip


def test_a_copied_folder_is_made_anew_by_the_python_behind_its_own(copied: Path) -> None:
    venv_of_another_folder(copied)
    done = start(copied, "table", **NOTHING_TO_REACH)
    assert "this folder was copied or moved" in done.stderr
    assert "package index cannot be reached" in failed_in_one_line(done)
    assert (copied / ".venv" / "pyvenv.cfg").exists(), "a .venv of its own"


def test_a_linked_environment_of_another_folder_is_left_alone(
    copied: Path, tmp_path: Path
) -> None:
    other = venv_of_another_folder(tmp_path / "other")
    (copied / ".venv").symlink_to(other)
    failed_in_one_line(start(copied, "table", **NOTHING_TO_REACH))
    assert (other / "flatplank.begun").read_text() == "of another folder"
    assert not (copied / ".venv").is_symlink()


@pytest.mark.parametrize(
    "words, code, said",
    [
        ("help", 0, "diagnose"),
        ("help diagnose", 0, "write a page with figures there"),
        ("slip --help", 0, "--free-rolling"),
        ("help diagnos", 2, "did you mean diagnose?"),
        ("--version", 0, "flatplank "),
        ("diagnos", 2, "did you mean diagnose?"),
        ("doctor", 1, "MISSING"),
    ],
)
def test_questions_install_nothing(copied: Path, words: str, code: int, said: str) -> None:
    done = start(copied, *words.split(), **NOTHING_TO_REACH)
    assert (done.returncode, said in done.stdout + done.stderr) == (code, True), done.stderr
    assert not any((copied / made).exists() for made in (".venv", ".cache", "ros_ws/install"))


def test_a_folder_that_cannot_be_written_is_one_line(copied: Path) -> None:
    (copied / ".cache").write_text("a file where the set-up wants a folder")
    line = failed_in_one_line(start(copied, "demo"))
    assert ".cache" in line and "must be writable" in line


def test_a_full_disk_is_one_line(copied: Path) -> None:
    command = f"ulimit -f 0; exec {copied}/flatplank table"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, timeout=280)
    failed_in_one_line(done)


def test_without_a_compiler_all_but_the_messages_is_built(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "tools" / "setup"))
    import workspace

    monkeypatch.setattr(workspace, "missing_for_build", lambda: ["g++", "cmake"])
    stale = ["flatplank_hw", "flatplank_msgs"]
    assert workspace.without_compiler(stale) == ["flatplank_hw"]
    (line,) = capsys.readouterr().err.splitlines()
    assert "no g++, cmake: flatplank_msgs is not built" in line


def test_the_sections_of_the_lock_are_those_that_the_set_up_asks_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "tools" / "setup"))
    import virtual

    asked = {*virtual.FIRST, *(name for names in virtual.MORE.values() for name in names)}
    headers = [s for s in virtual.LOCK.read_text().splitlines()[1:] if s.startswith("# ")]
    assert {header[2:].partition(":")[0] for header in headers} == asked
    assert any(line.startswith("scipy==") for line in virtual.locked("main"))
    assert any(line.startswith("uv==") for line in virtual.locked("workspace"))
    assert not any(line.startswith("nicegui") for line in virtual.locked("main"))


@pytest.mark.parametrize(
    ("folder", "name", "ours", "check"),
    [
        ("build", ".built_by", "colcon\n", check_and_mark_build_tool),
        (
            "install",
            ".colcon_install_layout",
            "isolated\n",
            partial(check_and_mark_install_layout, merge_install=False),
        ),
    ],
)
@pytest.mark.parametrize("before", [None, "", "another\n"])
def test_two_builds_at_once_do_not_refuse_each_other_s_folder(
    before: str | None,
    folder: str,
    name: str,
    ours: str,
    check: Callable[[Path], None],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """colcon opens its note on a folder and then writes it; the build beside it read an empty
    one: "was created by ''". A killed build leaves such a note, too."""
    monkeypatch.syspath_prepend(str(ROOT / "tools" / "setup"))
    import workspace

    note = tmp_path / folder / name
    if before is not None:
        note.parent.mkdir()
        note.write_text(before)
    seen = []
    monkeypatch.setattr(workspace, "WORKSPACE", tmp_path)
    monkeypatch.setattr(workspace, "CACHE", tmp_path)
    monkeypatch.setattr(workspace, "ros_setup", dict)
    monkeypatch.setattr(workspace, "package_stamps", lambda: {"one": SimpleNamespace(write=int)})
    monkeypatch.setattr(workspace, "run", lambda *_: seen.append(note.read_text()))
    workspace.build(["one"])
    assert seen == [before or ours], "another note is the user's: colcon says so"
    if not before:
        check(note.parent)
    assert [p.name for p in note.parent.iterdir()] == [note.name]
