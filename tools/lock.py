#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Write requirements/lock*.txt: every package, exact version, for each Python that we support.

    python3 tools/lock.py [PYTHON ...]      default: python3.10 ... python3.13 as found on PATH

Each interpreter resolves by itself (`pip install --dry-run`); where they disagree the line
carries a marker.
"""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
import tempfile
from collections import defaultdict
from pathlib import Path

REQUIREMENTS = Path(__file__).resolve().parent.parent / "requirements"
VERSIONS = ("3.10", "3.11", "3.12", "3.13")
LOCKS = {
    "lock.txt": (("ros", "build", "runtime", "test"), VERSIONS),
    "lock-jazzy.txt": (("jazzy", "build", "runtime", "test"), ("3.12",)),
}


def resolve(python: str, inputs: tuple[str, ...]) -> dict[str, str]:
    """What this interpreter's pip would install: {canonical name: exact version}."""
    with tempfile.TemporaryDirectory() as scratch:
        subprocess.run([python, "-m", "venv", f"{scratch}/venv"], check=True)
        report = Path(scratch, "report.json")
        command = [f"{scratch}/venv/bin/python", "-m", "pip", "install", "--quiet", "--dry-run"]
        command += ["--ignore-installed", "--report", str(report)]
        for name in inputs:
            command += ["-r", str(REQUIREMENTS / f"{name}.in")]
        subprocess.run(command, check=True)
        found = json.loads(report.read_text())["install"]
    packages = (item["metadata"] for item in found)
    return {re.sub(r"[-_.]+", "-", p["name"]).lower(): p["version"] for p in packages}


def merge(resolved: dict[str, dict[str, str]]) -> list[str]:
    """Lines of the lock: one per package and version, with a marker unless all agree."""
    users: dict[tuple[str, str], list[str]] = defaultdict(list)
    for python, packages in resolved.items():
        for name, version in packages.items():
            users[name, version].append(python)
    lines = []
    for (name, version), pythons in sorted(users.items()):
        if len(pythons) == len(resolved):
            lines.append(f"{name}=={version}")
        else:
            marker = " or ".join(f'python_version == "{p}"' for p in pythons)
            lines.append(f"{name}=={version} ; {marker}")
    return lines


def interpreters(given: list[str]) -> dict[str, str]:
    """{"3.11": path} of the interpreters to resolve with."""
    ask = "import sys; print('%d.%d' % sys.version_info[:2])"
    found = {}
    for candidate in given or [f"python{v}" for v in VERSIONS]:
        if path := shutil.which(candidate):
            run = subprocess.run([path, "-c", ask], capture_output=True, text=True)
            if run.returncode == 0:
                found[run.stdout.strip()] = path
    return found


def main() -> int:
    pythons = interpreters(sys.argv[1:])
    if missing := [v for v in VERSIONS if v not in pythons]:
        print(f"lock: no interpreter for Python {', '.join(missing)}: name them as arguments")
        return 1
    for file, (inputs, versions) in LOCKS.items():
        lines = merge({v: resolve(pythons[v], inputs) for v in versions})
        header = (
            f"# Made by tools/lock.py from {', '.join(f'{i}.in' for i in inputs)}; do not edit.\n"
        )
        (REQUIREMENTS / file).write_text(header + "\n".join(lines) + "\n")
        print(f"{file}: {len(lines)} lines")
    return 0


if __name__ == "__main__":
    sys.exit(main())
