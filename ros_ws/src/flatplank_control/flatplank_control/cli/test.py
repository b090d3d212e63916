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
from typing import IO

from flatplank_control.cli.doctor import project_root

CALCULATIONS = (
    ("discovery",),
    ("investigate", "analysis_models"),
    ("analysis_data", "blind"),
    ("campaign", "control", "formats", "plant", "slip_sweeps"),
)
"""folders of tests that only compute, in parts; they run at low priority beside the others, which
mostly wait for real time"""
WHOLE = ("-q", "-v", "--long", "--durations")
"""options with which the whole suite still runs in parts"""
LESS_URGENT = 10
"""niceness of the tests in CALCULATIONS"""
PYTEST = (sys.executable, "-m", "pytest")
CORES = 2
POLL_S = 0.2


def main(argv: list[str]) -> int:
    """Run pytest in the checkout; the exit code is that of pytest."""
    os.chdir(project_root())
    if all(word.split("=")[0] in WHOLE for word in argv):
        here = [*PYTEST, *argv, *(f"--ignore=tests/{n}" for part in CALCULATIONS for n in part)]
        beside = [*PYTEST, *argv, "-p", "no:cacheprovider"]
        return side_by_side(here, *([*beside, *map("tests/{}".format, p)] for p in CALCULATIONS))
    sys.stdout.flush()
    os.execv(sys.executable, [*PYTEST, *argv])


class Part:
    """A command that runs beside the first one, at lower priority, into a file of its own."""

    def __init__(self, command: Sequence[str], output: IO[bytes]) -> None:
        self.output = output
        self.process = subprocess.Popen(
            ["nice", "-n", str(LESS_URGENT), *command], stdout=output, stderr=subprocess.STDOUT
        )
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
    """Run a command, and others beside it: one at a time while it runs, then two at once. Their
    output follows that of the first. Returns the exit code of the first that failed."""
    waiting, parts = list(beside), list[Part]()
    with ExitStack() as opened:

        def begin(most: int) -> None:
            while waiting and sum(p.running for p in parts) < most:
                output = opened.enter_context(tempfile.TemporaryFile())
                parts.append(Part(waiting.pop(0), output))
                opened.callback(parts[-1].end)

        first = subprocess.Popen(here)
        opened.callback(first.wait)
        try:
            while first.poll() is None:
                begin(CORES - 1)
                time.sleep(POLL_S)
            print("\nCalculations, which ran beside:", flush=True)
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
