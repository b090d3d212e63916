#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Write docs/reference/licences.md: the licence of every package of the locks in requirements/.

    .venv/bin/python tools/licences.py    after tools/lock.py; needs the packages of `test`, too

A licence is what the package itself states: its licence expression, its classifiers, its line
`License`, or the `<license>` of its package.xml (ROS). Packages of other Pythons and of the locks
beside the environment are fetched into a scratch folder to read the same.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from collections import defaultdict
from collections.abc import Iterator
from importlib.metadata import Distribution, distributions
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/reference/licences.md"
FETCHED = (
    ("lock", "3.10"), ("lock", "3.13"), ("rivals", "3.10"), ("rivals", "3.13"),
    ("audit", "3.13"), ("site", "3.13"),
)  # fmt: skip
"""lock, and a Python whose packages are fetched when they are not installed here"""
NOT_STATED = "not stated in its metadata"
HEAD = """# Licences of the packages

Made by `tools/licences.py`; do not edit. All packages of the locks in `requirements/`, with what
each states as its licence.

| package | versions | locks | licence |
|---|---|---|---|
"""


def locked() -> Iterator[tuple[str, str, str, str]]:
    """Name, version, lock, and line with hashes of every locked package."""
    for lock in sorted((ROOT / "requirements").glob("*.txt")):
        for line in lock.read_text().replace("\\\n", "").splitlines():
            if not line.startswith("#") and "win32" not in line:
                name, version = re.split(r"==|[\s;]", line)[:2]
                yield name.lower(), version, lock.stem, line


def stated(package: Distribution) -> str:
    """The licence that a package states; empty: none."""
    told = package.metadata
    classes = [c.rpartition(" :: ")[2] for c in told.get_all("Classifier") or []
               if c.startswith("License ::")]  # fmt: skip
    line = (told.get("License") or "").strip()
    short = line if line not in ("UNKNOWN", "%LICENSE") and len(line) < 60 else ""
    manifests = [f for f in package.files or [] if f.name == "package.xml"]
    texts = [Path(str(f.locate())).read_text(errors="replace") for f in manifests]
    ros = sorted({m for text in texts for m in re.findall(r"<license[^>]*>([^<]+)<", text)})
    return told.get("License-Expression") or " / ".join(classes) or short or ", ".join(ros)


def licences(folder: str) -> dict[str, str]:
    """By canonical name: the licence of each package in a folder."""
    found = distributions(path=[folder])
    return {re.sub(r"[-_.]+", "-", d.name).lower(): stated(d) for d in found}


def fetched(lines: list[str], python: str) -> dict[str, str]:
    """Licences of packages that are not installed here, as a Python gets them."""
    with tempfile.TemporaryDirectory() as scratch:
        wanted = Path(scratch, "wanted.txt")
        wanted.write_text("\n".join(lines) + "\n")
        command = [sys.executable, "-m", "uv", "pip", "install", "--quiet", "--no-deps"]
        command += ["--require-hashes", "--python-version", python, "--target", scratch]
        subprocess.run([*command, "-r", str(wanted)], check=True)
        return licences(scratch)


def main() -> int:
    packages = list(locked())
    known = {k: v for folder in sys.path for k, v in licences(folder).items()}
    for lock, python in FETCHED:
        lacking = [line for name, _, stem, line in packages if stem == lock and name not in known]
        known = fetched(lacking, python) | known if lacking else known
    versions, locks = defaultdict(set), defaultdict(set)
    for name, version, lock, _ in packages:
        versions[name].add(version)
        locks[name].add(lock)
    rows = [
        f"| {name} | {', '.join(sorted(versions[name]))} | {', '.join(sorted(locks[name]))} "
        f"| {known[name] or NOT_STATED} |"
        for name in sorted(versions)
    ]
    PAGE.write_text(HEAD + "\n".join(rows) + "\n")
    print(f"{PAGE}: {len(rows)} packages, {sum(NOT_STATED in row for row in rows)} state none")
    return 0


if __name__ == "__main__":
    sys.exit(main())
