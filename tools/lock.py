#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Write requirements/lock*.txt: every package, exact version, for each Python that we support.

    .venv/bin/python tools/lock.py              new packages; versions that are locked stay
    .venv/bin/python tools/lock.py --upgrade    everything anew

A lock has a section per group of packages; each section holds what the ones above it do not have.
Where the Pythons disagree the line carries a marker.
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
Package = tuple[str, str]
"""canonical name, exact version"""


def resolve(python: str, inputs: list[str], keep: Path | None) -> set[Package]:
    """What a Python would get for these inputs, with the versions of a lock where it has them."""
    command = [sys.executable, "-m", "uv", "pip", "compile", "--quiet", "--python-version", python]
    command += ["--no-header", "--no-annotate", "--no-strip-extras"]
    command += [str(REQUIREMENTS / f"{name}.in") for name in inputs]
    command += ["--constraints", str(keep)] if keep else []
    text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    pairs = (re.split(r"==|\s*;", line)[:2] for line in text.splitlines())
    return {(re.sub(r"\[.*", "", name), version.strip()) for name, version in pairs}


def lines_of(users: dict[Package, list[str]], versions: tuple[str, ...]) -> list[str]:
    """Lines of a section: one per package and version, with a marker unless all agree."""
    lines = []
    for (name, version), pythons in sorted(users.items()):
        marker = " or ".join(f'python_version == "{p}"' for p in pythons)
        everywhere = len(pythons) == len(versions)
        lines.append(f"{name}=={version}" + ("" if everywhere else f" ; {marker}"))
    return lines


def sections(
    groups: dict[str, tuple[str, ...]], versions: tuple[str, ...], keep: Path | None
) -> list[str]:
    """All sections of a lock, each under its header."""
    inputs: list[str] = []
    before: dict[str, set[Package]] = defaultdict(set)
    lines = []
    for group, names in groups.items():
        inputs += names
        users: dict[Package, list[str]] = defaultdict(list)
        for python in versions:
            for package in resolve(python, inputs, keep) - before[python]:
                users[package].append(python)
                before[python].add(package)
        lines += [f"# {group}: {', '.join(f'{name}.in' for name in names)}"]
        lines += lines_of(users, versions)
    return lines


def main() -> int:
    for file, (groups, versions) in LOCKS.items():
        lock = REQUIREMENTS / file
        with tempfile.TemporaryDirectory() as scratch:
            keep = None
            if "--upgrade" not in sys.argv:
                keep = Path(scratch, "keep.txt")
                keep.write_text(lock.read_text())
            lines = sections(groups, versions, keep)
        lock.write_text("\n".join(["# Made by tools/lock.py; do not edit.", *lines]) + "\n")
        print(f"{file}: {len(lines) - len(groups)} lines")
    return 0


if __name__ == "__main__":
    sys.exit(main())
