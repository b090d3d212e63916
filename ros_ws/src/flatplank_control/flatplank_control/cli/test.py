# SPDX-License-Identifier: Apache-2.0
"""Run the tests of the project.

[--long] [-k EXPR] [FILE ...]; further options go to pytest.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import IO

from flatplank_control.cli.doctor import project_root

CALCULATIONS = (
    ("tests/discovery",),
    ("tests/investigate", "tests/analysis_models"),
    ("tests/blind",),
    ("tests/campaign", "tests/control", "tests/plant"),
    ("tests/analysis_data", "tests/formats", "tests/slip_sweeps", "tests/tire"),
)
"""folders of tests that only compute; none of them keeps time"""
SEARCHES = 4
"""parts of the first of CALCULATIONS, which alone would last longer than all the others"""
WHOLE = ("-q", "-v", "--long", "--durations")
"""options with which the whole suite still runs in parts"""
LESS_URGENT = 10
"""niceness of the tests beside those with nodes and pages, which keep time"""
TIMES = Path(".cache/test-times.tsv")
"""processor time [s] and name of each test of the last whole run and those after it; written by
tests/conftest.py"""
PYTEST = (sys.executable, "-m", "pytest")
CORES = 2
POLL_S = 0.2


def main(argv: list[str]) -> int:
    """Run pytest in the checkout; the exit code is that of pytest."""
    os.chdir(project_root())
    if all(word.split("=")[0] in WHOLE for word in argv):
        here = [*PYTEST, *argv, *(f"--ignore={name}" for part in CALCULATIONS for name in part)]
        beside = [*PYTEST, *argv, "-p", "no:cacheprovider"]
        TIMES.unlink(missing_ok=True)
        niced = ["nice", "-n", str(LESS_URGENT), *beside]
        return side_by_side(here, *([*niced, *part] for part in parts()))
    sys.stdout.flush()
    os.execv(sys.executable, [*PYTEST, *argv])


def parts() -> list[Sequence[str]]:
    """What each part of the calculations is asked for; the files of the first folder by turns, so
    that its parts last about as long."""
    (searches,), *others = CALCULATIONS
    files = sorted(str(path) for path in Path(searches).glob("test_*.py"))
    return [*(files[k::SEARCHES] for k in range(SEARCHES)), *others]


class Part:
    """A command that runs beside the first one, into a file of its own and on one core: what keeps
    time has the others, and threads of a calculation would only wait for each other."""

    def __init__(self, command: Sequence[str], output: IO[bytes], core: int) -> None:
        self.output, self.core = output, core
        self.process = subprocess.Popen(command, stdout=output, stderr=subprocess.STDOUT)
        os.sched_setaffinity(self.process.pid, {core})
        self.shown = 0

    @property
    def running(self) -> bool:
        return self.process.poll() is None

    def show(self) -> None:
        """Print what was written since the last time."""
        while text := os.pread(self.output.fileno(), 1 << 16, self.shown):
            self.shown += len(text)
            sys.stdout.buffer.write(text)
            sys.stdout.flush()

    def end(self) -> None:
        if self.running:
            self.process.terminate()
            self.process.wait()


def side_by_side(here: Sequence[str], *beside: Sequence[str]) -> int:
    """Run a command, and others beside it: one at a time while it runs, because it keeps time,
    then one per core. Their output follows its own. Returns the exit code of the first that
    failed."""
    waiting, parts = list(beside), list[Part]()
    cores = sorted(os.sched_getaffinity(0), reverse=True)
    with ExitStack() as opened:

        def begin(most: int) -> None:
            while waiting and len(busy := [p.core for p in parts if p.running]) < most:
                output = opened.enter_context(tempfile.TemporaryFile())
                core = min(cores, key=busy.count)
                parts.append(Part(waiting.pop(0), output, core))
                opened.callback(parts[-1].end)

        first = subprocess.Popen(here)
        opened.callback(first.wait)
        try:
            while first.poll() is None:
                begin(CORES - 1)
                time.sleep(POLL_S)
            print("\nWhat ran beside:", flush=True)
            shown = 0
            while shown < len(beside):
                begin(CORES)
                ended = not parts[shown].running
                parts[shown].show()
                shown += ended
                if not ended:
                    time.sleep(POLL_S)
        except KeyboardInterrupt:
            for part in parts:
                part.process.wait()
            return 130
    code = next((c for c in (first.returncode, *(p.process.returncode for p in parts)) if c), 0)
    print("all parts passed" if code == 0 else "a part failed, see above", flush=True)
    return code
