# SPDX-License-Identifier: Apache-2.0
"""Start the nodes of a bench as processes, and end them by their ids."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

from flatplank_control.bench.setup import BenchSetup
from flatplank_hw.parent import END_WITH_PARENT

GRACE = 5.0
"""a node has so long to end by itself [s]"""


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
        self.running[name] = subprocess.Popen(
            command,
            env=self._environment,
            stdin=subprocess.DEVNULL,
            stdout=self._log,
            stderr=self._log,
            start_new_session=True,
        )

    def ended(self) -> dict[str, int]:
        """Nodes that have ended by themselves and their exit codes."""
        nodes = tuple(self.running.items())  # more may just be started by another thread
        return {name: p.returncode for name, p in nodes if p.poll() is not None}

    def stop(self) -> None:
        for process in self.running.values():
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
        for process in self.running.values():
            try:
                process.wait(GRACE)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self.running.clear()
        if self._log:
            self._log.close()
            self._log = None
        self._folder.cleanup()

    def __enter__(self) -> BenchProcesses:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()
