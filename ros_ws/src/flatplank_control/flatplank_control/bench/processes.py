# SPDX-License-Identifier: Apache-2.0
"""Start the nodes of a bench as processes, and end them by their ids."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path

from flatplank_control.bench.setup import BenchSetup
from flatplank_control.bench.shared_memory import remove_orphans
from flatplank_control.bench.starting import Vitals
from flatplank_hw.parent import END_WITH_PARENT, STARTED

GRACE = 30.0
"""the nodes have so long to end by themselves [s]"""

TICK_S = 1.0 / os.sysconf("SC_CLK_TCK")
"""unit of the times in /proc/PID/stat [s]"""


class BenchProcesses:
    """The nodes of a bench; a context manager that leaves no process behind."""

    def __init__(
        self,
        setup: BenchSetup,
        *,
        environment: Mapping[str, str] | None = None,
        log: Path | None = None,
        without: frozenset[str] = frozenset(),
    ) -> None:
        """`log`: a file for what the nodes print; None: the terminal. `without`: names not
        started.
        """
        self.setup = setup
        self.running: dict[str, subprocess.Popen] = {}
        self._environment = {
            **os.environ,
            END_WITH_PARENT: str(os.getpid()),
            **(environment or {}),
        }
        self.log = log
        self._log = open(log, "ab") if log else None  # noqa: SIM115  open as long as the nodes
        self._without = without
        self._folder = tempfile.TemporaryDirectory(prefix="flatplank-")
        self._files = setup.write(Path(self._folder.name))

    def start(self) -> None:
        for node in self.setup.nodes():
            if node.name not in self._without:
                self.start_node(node.name)

    def start_node(self, name: str) -> None:
        """Start one node of the set-up, also again after it has ended."""
        node = next(n for n in self.setup.nodes() if n.name == name)
        command = [
            sys.executable,
            "-m",
            f"{node.package}.nodes.{node.executable}",
            "--ros-args",
            "-r",
            f"__node:={node.name}",
            "--params-file",
            str(self._files[name]),
        ]
        started = self._started(name)
        started.unlink(missing_ok=True)
        self.running[name] = subprocess.Popen(
            command,
            env={**self._environment, STARTED: str(started)},
            stdin=subprocess.DEVNULL,
            stdout=self._log,
            stderr=self._log,
            start_new_session=True,
        )

    def ended(self) -> dict[str, int]:
        """Nodes that have ended by themselves and their exit codes."""
        nodes = tuple(self.running.items())  # more may just be started by another thread
        return {name: p.returncode for name, p in nodes if p.poll() is not None}

    def why_ended(self) -> str:
        """Nodes that have ended by themselves, each with its exit code and last words."""
        return "; ".join(
            f"{name} ended by itself ({_ending(code)}): {self._last_words(name)}"
            for name, code in self.ended().items()
        )

    def vitals(self) -> dict[str, Vitals]:
        """What the system says of the nodes that live."""
        found = {}
        for name, process in tuple(self.running.items()):
            try:
                stat = Path(f"/proc/{process.pid}/stat").read_text()
            except OSError:
                continue
            state, *numbers = stat.rpartition(")")[2].split()
            cpu = TICK_S * (int(numbers[10]) + int(numbers[11]))
            found[name] = Vitals(state, cpu, self._started(name).exists())
        return found

    def stop(self) -> None:
        """End all nodes; those that do not end by themselves are killed."""
        for process in self.running.values():
            if process.poll() is None:
                process.send_signal(signal.SIGTERM)
                process.send_signal(signal.SIGCONT)
        end = time.monotonic() + GRACE
        for process in self.running.values():
            try:
                process.wait(max(end - time.monotonic(), 0.0))
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        if any(process.returncode < 0 for process in self.running.values()):
            remove_orphans()
        self.running.clear()
        if self._log:
            self._log.close()
            self._log = None
        self._folder.cleanup()

    def _started(self, name: str) -> Path:
        """The file by which a node says that it listens."""
        return Path(self._folder.name, f"{name}.started")

    def _last_words(self, name: str) -> str:
        """The last line of the log that is this node's, else the last that is nobody's."""
        if self.log is None:
            return "its last lines are above"
        lines = self.log.read_text(errors="replace").splitlines()
        lines = [line.strip() for line in lines if line.strip()]
        others = "|".join(map(re.escape, self.running.keys() - {name})) or "$^"
        own = [line for line in lines if f"[{name}]" in line]
        rest = [line for line in lines if not re.search(rf"\[({others})\]", line)]
        return f"{(own or rest or ['no word of it'])[-1]} ({self.log})"

    def __enter__(self) -> BenchProcesses:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()


def _ending(code: int) -> str:
    if code < 0:
        return f"killed by {signal.Signals(-code).name}"
    return f"exit code {code}"
