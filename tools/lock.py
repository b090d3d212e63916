#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Write the locks of requirements/: every package, its exact version, the hashes of its files.

    .venv/bin/python tools/lock.py              after an edit of a *.in; locked versions stay
    .venv/bin/python tools/lock.py --upgrade    everything anew

A lock of the environment has a section per group of packages; each section holds what the ones
above it do not have. Where the Pythons disagree the line carries a marker. The hashes are those of
all files of a version in the index, for every Python and processor.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from collections import defaultdict
from pathlib import Path

REQUIREMENTS = Path(__file__).resolve().parent.parent / "requirements"
VERSIONS = ("3.10", "3.11", "3.12", "3.13")
AFTER_ROS = {"main": ("runtime",), "panel": ("panel",), "test": ("test",)}
LOCKS = {
    "lock.txt": ({"workspace": ("ros", "build"), **AFTER_ROS}, VERSIONS),
    "lock-jazzy.txt": ({"workspace": ("jazzy", "build"), **AFTER_ROS}, ("3.12",)),
}
ASIDE = {"audit": "3.10", "site": "3.11.5", "rivals": "3.10"}
"""lock of what is no part of the environment -> the oldest Python that it is for"""

Package = tuple[str, str]
"""canonical name, exact version"""
Hashes = dict[Package, set[str]]
"""of each package the hashes of its files"""


def compiled(inputs: list[str], keep: Path | None, *options: str) -> str:
    """uv's lock of these inputs, with the versions of `keep` where it has them."""
    command = [sys.executable, "-m", "uv", "pip", "compile", "--quiet", "--generate-hashes"]
    command += ["--no-header", "--no-annotate", *options]
    command += [str(REQUIREMENTS / f"{name}.in") for name in inputs]
    command += ["--constraints", str(keep)] if keep else []
    command += ["--overrides", str(REQUIREMENTS / "overrides.in")]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def resolve(python: str, inputs: list[str], keep: Path | None) -> Hashes:
    """The packages that a Python would get for these inputs."""
    text = compiled(inputs, keep, "--python-version", python, "--no-strip-extras")
    found = {}
    for line in text.replace("\\\n", "").splitlines():
        name, version = re.split(r"==|[\s;]", re.sub(r"\[.*?\]", "", line))[:2]
        found[name, version] = set(re.findall(r"--hash=\S+", line))
    return found


def lines_of(users: dict[Package, list[str]], every: Hashes, pythons: int) -> list[str]:
    """Lines of a section: package and version, with a marker unless all agree, and hashes."""
    lines = []
    for package, who in sorted(users.items()):
        marker = " or ".join(f'python_version == "{p}"' for p in who)
        wanted = "==".join(package) + ("" if len(who) == pythons else f" ; {marker}")
        lines.append(" \\\n    ".join([wanted, *sorted(every[package])]))
    return lines


def sections(
    groups: dict[str, tuple[str, ...]], versions: tuple[str, ...], keep: Path | None
) -> str:
    """All sections of a lock, each under its header."""
    inputs: list[str] = []
    before: dict[str, set[Package]] = defaultdict(set)
    every: Hashes = defaultdict(set)
    lines = []
    for group, names in groups.items():
        inputs += names
        users: dict[Package, list[str]] = defaultdict(list)
        for python in versions:
            found = resolve(python, inputs, keep)
            for package, hashes in found.items():
                every[package] |= hashes
                if package not in before[python]:
                    users[package].append(python)
            before[python] |= found.keys()
        lines += [f"# {group}: {', '.join(f'{name}.in' for name in names)}"]
        lines += lines_of(users, every, len(versions))
    return "\n".join(lines) + "\n"


def kept(lock: Path, folder: str) -> Path | None:
    """The versions of a lock, which are to stay; None when everything is to be anew."""
    if "--upgrade" in sys.argv or not lock.exists():
        return None
    copy = Path(folder, lock.name)
    copy.write_text(re.sub(r" \\\n +--hash=\S+", "", lock.read_text()))
    return copy


def main() -> int:
    with tempfile.TemporaryDirectory() as scratch:
        texts = {}
        for file, (groups, versions) in LOCKS.items():
            texts[file] = sections(groups, versions, kept(REQUIREMENTS / file, scratch))
        for name, python in ASIDE.items():
            keep = kept(REQUIREMENTS / f"{name}.txt", scratch)
            options = ("--universal", "--python-version", python)
            texts[f"{name}.txt"] = f"# {name}: {name}.in\n{compiled([name], keep, *options)}"
    for file, text in texts.items():
        (REQUIREMENTS / file).write_text(f"# Made by tools/lock.py; do not edit.\n{text}")
        packages = len(re.findall("(?m)^[a-z0-9]", text))
        print(f"{file}: {packages} lines of packages, {text.count('--hash=')} hashes")
    return 0


if __name__ == "__main__":
    sys.exit(main())
