#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Known vulnerabilities of the locked packages, by pip-audit.

    .venv/bin/python tools/vulnerabilities.py [LOCK...]    by default requirements/lock.txt

Exit code 0: none is known; 1: some are, one line each; 2: no database could be asked. pip-audit
and what it needs are installed in .cache/audit from requirements/audit.txt. The answer is for the
Python that runs this.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
REQUIREMENTS = ROOT / "requirements"
TOOL = ROOT / ".cache" / "audit"
SERVICES = ("pypi", "osv")
"""databases that pip-audit knows, asked in this order until one answers"""


def ready() -> str:
    """Make pip-audit ready in a folder of its own; return why that failed."""
    lock = REQUIREMENTS / "audit.txt"
    done = TOOL / "done"
    if done.exists() and done.read_text() == lock.read_text():
        return ""
    command = [sys.executable, "-m", "uv", "pip", "install", "--quiet", "--require-hashes"]
    made = subprocess.run(
        [*command, "--target", str(TOOL), "-r", str(lock)], capture_output=True, text=True
    )
    if made.returncode == 0:
        done.write_text(lock.read_text())
    return made.stderr.strip()


def asked(lock: Path, service: str) -> tuple[list[dict] | None, str]:
    """Packages of a lock with their vulnerabilities; None and the reason without an answer."""
    command = [sys.executable, "-m", "pip_audit", "--requirement", str(lock), "--require-hashes"]
    command += ["--disable-pip", "--format", "json", "--progress-spinner", "off"]
    env = os.environ | {"PYTHONPATH": str(TOOL)}
    told = subprocess.run(
        [*command, "--vulnerability-service", service], capture_output=True, text=True, env=env
    )
    try:
        packages = json.loads(told.stdout)["dependencies"]
    except ValueError:
        return None, (told.stderr.strip().splitlines() or ["no answer"])[-1][:160][:160]
    if all("skip_reason" in p for p in packages):
        return None, "it knows none of the packages"
    return packages, ""


def report(lock: Path) -> int:
    """Print what is known of a lock; return the exit code."""
    reasons = []
    for service in SERVICES:
        packages, why = asked(lock, service)
        if packages is not None:
            break
        reasons.append(f"{service}: {why}")
    else:
        print(f"{lock.name}: no database could be asked ({'; '.join(reasons)})", file=sys.stderr)
        return 2
    unknown = [p["name"] for p in packages if "skip_reason" in p]
    found = [(p, v) for p in packages for v in p.get("vulns", [])]
    for package, known in found:
        mended = ", ".join(known["fix_versions"]) or "no version yet"
        print(f"{package['name']} {package['version']}: {known['id']}, mended in {mended}")
    print(
        f"{lock.name}: {len(packages) - len(unknown)} packages asked of {service}, "
        f"{len(found)} vulnerabilities known, {len(unknown)} packages unknown there"
    )
    return 1 if found else 0


def main(argv: list[str]) -> int:
    if why := ready():
        print(f"pip-audit cannot be installed: {why}", file=sys.stderr)
        return 2
    locks = [Path(text) for text in argv] or [REQUIREMENTS / "lock.txt"]
    return max(report(lock) for lock in locks)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
