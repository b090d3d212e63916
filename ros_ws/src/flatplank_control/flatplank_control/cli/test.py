# SPDX-License-Identifier: Apache-2.0
"""Runs the tests of the project: [--long] [-k EXPR] [FILE ...]; further options go to pytest."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence

from flatplank_control.cli.doctor import project_root

CALCULATIONS = (
    "analysis_data", "analysis_models", "blind", "campaign", "control", "discovery", "formats",
    "investigate", "plant", "slip_sweeps",
)  # fmt: skip
"""folders of tests that only compute; they run at low priority beside the others, which mostly
wait for real time"""
WHOLE = ("-q", "-v", "--long", "--durations")
"""options with which the whole suite still runs, in two parts"""
LESS_URGENT = 10
"""niceness of the tests in CALCULATIONS"""
PYTEST = (sys.executable, "-m", "pytest")


def main(argv: list[str]) -> int:
    """Run pytest in the checkout; the exit code is that of pytest."""
    os.chdir(project_root())
    if all(word.split("=")[0] in WHOLE for word in argv):
        here = [*PYTEST, *argv, *(f"--ignore=tests/{name}" for name in CALCULATIONS)]
        beside = [*PYTEST, *argv, "-p", "no:cacheprovider"]
        return side_by_side(here, [*beside, *(f"tests/{name}" for name in CALCULATIONS)])
    sys.stdout.flush()
    os.execv(sys.executable, [*PYTEST, *argv])


def side_by_side(here: Sequence[str], beside: Sequence[str]) -> int:
    """Run two commands at once, the second at lower priority; its output follows that of the
    first. Returns the exit code of the first that failed."""
    with tempfile.TemporaryFile() as output:
        second = subprocess.Popen(
            ["nice", "-n", str(LESS_URGENT), *beside], stdout=output, stderr=subprocess.STDOUT
        )
        try:
            first = subprocess.run(here, check=False).returncode
            print("\nCalculations, which ran beside:", flush=True)
            follow(output.fileno(), second)
        except KeyboardInterrupt:
            second.wait()
            return 130
        finally:
            if second.poll() is None:
                second.terminate()
                second.wait()
    code = first or second.returncode
    print("both parts passed" if code == 0 else "a part failed, see above", flush=True)
    return code


def follow(descriptor: int, process: subprocess.Popen) -> None:
    """Print the output of a process until it ends."""
    place, ended = 0, False
    while not ended:
        ended = process.poll() is not None
        while text := os.pread(descriptor, 1 << 16, place):
            place += len(text)
            sys.stdout.buffer.write(text)
            sys.stdout.flush()
        if not ended:
            time.sleep(0.2)
