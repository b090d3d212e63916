# SPDX-License-Identifier: Apache-2.0
"""Starts the nodes of a bench as processes, supervises their start, and ends them by their ids.

The wait for a start depends on the progress of the nodes, not on the clock. A node that loads its
modules uses the processor, or waits for the processor or the disk. The wait continues as long as a
node does so."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from flatplank_control.bench.fast_dds import remove_orphans
from flatplank_control.bench.setup import BenchSetup, NodeSpec
from flatplank_hw.process import END_WITH_PARENT, STARTED

STALL_TIMEOUT_S = 60.0
"""longest time without progress of any node [s of wall clock]"""

RUNAWAY_CPU_S = 600.0
"""processor time after which the start fails when the node is not up [s]"""

NOTICED_CPU_S = 0.02
"""processor time that counts as progress [s]; the clock tick of the kernel is 0.01 s"""


@dataclass(frozen=True)
class ProcessState:
    """State of a live process, from /proc."""

    state: str
    """process state as in /proc/PID/stat: R, S, D, T, ..."""
    cpu_s: float
    started: bool
    """true once its node is ready"""

    @property
    def waits_for_the_machine(self) -> bool:
        """True when it waits only for a processor or the disk."""
        return self.state in ("R", "D")


class StartProgress:
    """Progress of a start: the answers of the nodes, and the time of the last change."""

    def __init__(self, names: Collection[str], now: float, stall_s: float = STALL_TIMEOUT_S):
        """`now` is the wall clock [s], here and in all methods."""
        self.up_at: dict[str, float] = {}
        """node -> time of its first answer that it is up [s]"""
        self._lacks: dict[str, str | None] = dict.fromkeys(names)
        self._cpu = dict.fromkeys(names, 0.0)
        self._progress_at = now
        self._stall_s = stall_s

    def register_answer(self, name: str, lacks: str, now: float) -> None:
        """Register an answer; `lacks`: what the node still waits for, empty when it is up."""
        if self._lacks[name] != lacks:
            self._lacks[name] = lacks
            self._progress_at = now
            if not lacks:
                self.up_at[name] = now

    @property
    def missing(self) -> list[str]:
        """Nodes that are not up."""
        return [name for name, lacks in self._lacks.items() if lacks != ""]

    def __str__(self) -> str:
        total = len(self._lacks)
        return f"{total - len(self.missing)} of {total} nodes are up"

    def why_waiting_is_useless(self, vitals: Mapping[str, ProcessState], now: float) -> str:
        """Reason why further waiting is useless; empty when it is not.

        `vitals`: nodes whose processes are known and live.
        """
        for name in self.missing:
            seen = vitals.get(name)
            if seen is None or seen.started:
                continue
            if seen.cpu_s > RUNAWAY_CPU_S:
                return f"{name}: not up after {seen.cpu_s:.0f} s of processor time; {self}"
            if seen.waits_for_the_machine or seen.cpu_s - self._cpu[name] >= NOTICED_CPU_S:
                self._cpu[name] = seen.cpu_s
                self._progress_at = now
        if now - self._progress_at <= self._stall_s:
            return ""
        hangs = "; ".join(self._hangs(name, vitals.get(name)) for name in self.missing[:3])
        return f"{hangs}; nothing has changed for {self._stall_s:.0f} s, {self}"

    def _hangs(self, name: str, seen: ProcessState | None) -> str:
        if lacks := self._lacks[name]:
            return f"{name} waits: {lacks}"
        if seen is None:
            return f"{name} does not answer; is the bench running?"
        if seen.started:
            return f"{name} runs, but its services are not heard"
        if seen.state in "Tt":
            return f"{name} is stopped"
        return f"{name} hangs before the node is created, and uses no processor"


GRACE = 30.0
"""time for the nodes to end by themselves [s]"""

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
        """`log`: file for the output of the nodes; None: the terminal. `without`: names of nodes
        that are not started.
        """
        self.setup = setup
        self.running: dict[str, subprocess.Popen] = {}
        """processes by name: that of their node, or `loop`"""
        ours = {END_WITH_PARENT: str(os.getpid())}
        self._environment = {**os.environ, **ours, **(environment or {})}
        self.log = log
        self._log = open(log, "ab") if log else None  # noqa: SIM115  open as long as the nodes
        planned = {
            name: tuple(node for node in nodes if node.name not in without)
            for name, nodes in setup.processes().items()
        }
        self._planned = {name: nodes for name, nodes in planned.items() if nodes}
        self._folder = tempfile.TemporaryDirectory(prefix="flatplank-")
        self._files = setup.write(Path(self._folder.name))

    def start(self) -> None:
        for name in self._planned:
            self.start_process(name)

    def start_process(self, name: str) -> None:
        """Start one process of the set-up, also again after it has ended."""
        nodes = self._planned[name]
        started = self._started(name)
        started.unlink(missing_ok=True)
        self.running[name] = subprocess.Popen(
            [sys.executable, "-m", *program(nodes, self._files, self.setup.namespace)],
            env={**self._environment, STARTED: str(started)},
            stdin=subprocess.DEVNULL,
            stdout=self._log,
            stderr=self._log,
            start_new_session=True,
        )

    def nodes(self) -> dict[str, str]:
        """Nodes that were started -> their processes."""
        return {node.name: process for process in self.running for node in self._planned[process]}

    def ended(self) -> dict[str, int]:
        """Nodes that have ended by themselves and their exit codes."""
        nodes = tuple(self.running.items())  # another thread may be starting further nodes
        return {name: p.returncode for name, p in nodes if p.poll() is not None}

    def why_ended(self) -> str:
        """Nodes that have ended by themselves, each with its exit code and last line."""
        return "; ".join(
            f"{name} ended by itself ({_ending(code)}): {self._last_words(name)}"
            for name, code in self.ended().items()
        )

    def vitals(self) -> dict[str, ProcessState]:
        """State of the processes of live nodes, by node."""
        found = {}
        for node, name in self.nodes().items():
            process = self.running[name]
            try:
                stat = Path(f"/proc/{process.pid}/stat").read_text()
            except OSError:
                continue
            state, *numbers = stat.rpartition(")")[2].split()
            cpu = TICK_S * (int(numbers[10]) + int(numbers[11]))
            found[node] = ProcessState(state, cpu, self._started(name).exists())
        return found

    def stop(self) -> None:
        """End all nodes; kill those that do not end by themselves."""
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
        """File by which a node reports that it is ready."""
        return Path(self._folder.name, f"{name}.started")

    def _last_words(self, name: str) -> str:
        """Last line of the log from this node, else the last line that names no other node."""
        if self.log is None:
            return "its last lines are above"
        lines = self.log.read_text(errors="replace").splitlines()
        lines = [line.strip() for line in lines if line.strip()]
        process_of = self.nodes()
        others = "|".join(re.escape(n) for n, process in process_of.items() if process != name)
        ours = [f"[{n}]" for n, process in process_of.items() if process == name]
        own = [line for line in lines if any(node in line for node in ours)]
        rest = [line for line in lines if not re.search(rf"\[({others or '$^'})\]", line)]
        return f"{(own or rest or ['it wrote no line'])[-1]} ({self.log})"

    def __enter__(self) -> BenchProcesses:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()


def program(
    nodes: Sequence[NodeSpec], files: Mapping[str, Path], namespace: str = ""
) -> list[str]:
    """Module and arguments that run nodes in one process; `files`: parameter file by node."""
    where = ["-r", f"__ns:={namespace}"] if namespace else []
    given = [*where, *arguments_of_files(nodes, files)]
    if len(nodes) == 1:
        (node,) = nodes
        return [node.module, "--ros-args", "-r", f"__node:={node.name}", *given]
    return ["flatplank_control.nodes.loop", *words_of_nodes(nodes), "--ros-args", *given]


def words_of_nodes(nodes: Sequence[NodeSpec]) -> list[str]:
    """Arguments of the program `loop`: its nodes."""
    return [f"{node.name}={node.module}" for node in nodes]


def arguments_of_files(nodes: Sequence[NodeSpec], files: Mapping[str, Path]) -> list[str]:
    """ROS arguments that name the parameter files."""
    return [word for node in nodes for word in ("--params-file", str(files[node.name]))]


def _ending(code: int) -> str:
    return f"killed by {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
