# SPDX-License-Identifier: Apache-2.0
"""The emulated bus in one object: namespace, emulator process, control socket and matching client.

`flatplank bench --emulated-bus` and the tests use it.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

from flatplank_data.errors import FlatplankError
from flatplank_hw.ethercat.master import BusClient, BusError
from flatplank_hw.process import child_environment
from flatplank_sim.emulator.control import Control

MASTER, EMULATOR = "veth0", "veth1"
"""ends of the veth pair"""
_HOLD = (
    "ip link add {0} type veth peer name {1} && ip link set {0} up && ip link set {1} up"
    " && echo ready && exec cat"
)


class NamespaceError(FlatplankError):
    """No network namespace can be made; one line with the reason."""


class BenchNamespace(AbstractContextManager):
    """A network namespace, held open by a process that waits for the end of its input."""

    def __init__(self) -> None:
        for tool in ("unshare", "nsenter", "ip"):
            if shutil.which(tool) is None:
                raise NamespaceError(f"'{tool}' is missing; apt-get install iproute2 util-linux")
        flags = ["-n"] if os.geteuid() == 0 else ["-U", "-r", "-n"]
        self._holder = subprocess.Popen(
            ["unshare", *flags, "sh", "-c", _HOLD.format(MASTER, EMULATOR)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        assert self._holder.stdout is not None
        if self._holder.stdout.readline().strip() != b"ready":
            _, errors = self._holder.communicate()
            text = errors.decode().strip().partition("\n")[0]
            raise NamespaceError(f"no network namespace with a veth pair: {text}")
        own = ["-U", "--preserve-credentials"] if os.geteuid() != 0 else []
        self.enter = ["nsenter", "-t", str(self._holder.pid), *own, "-n"]
        """words in front of a command that is to run in the namespace"""

    def run(self, *command: str) -> None:
        """Run a command in the namespace, for instance `ip link set veth0 down`."""
        subprocess.run([*self.enter, *command], check=True, capture_output=True)

    def close(self) -> None:
        """Release the namespace; it exists until the last process in it has ended."""
        self._holder.communicate()

    def __exit__(self, *_: object) -> None:
        self.close()


REPLY_TIMEOUT_MS = 12.0
"""reply time-out; long, because emulator and master share a computer with other work [ms]"""
WAIT_MS = 1000.0
"""longest wait for the answer of nodes that share the computer [ms]"""


class EmulatorProcess:
    """The emulator as a separate process inside a namespace; it ends with this process."""

    def __init__(
        self, namespace: BenchNamespace, bus_file: str | Path, arguments: Sequence[str] = ()
    ) -> None:
        """arguments: further command-line arguments. BusError when it does not start."""
        self._folder = tempfile.TemporaryDirectory(prefix="fp-")
        self.control_path = f"{self._folder.name}/control"
        words = [*namespace.enter, sys.executable, "-m", "flatplank_sim.emulator"]
        words += ["--interface", EMULATOR, "--bus", str(bus_file)]
        words += ["--control", self.control_path, "--with-parent", "--fifo", *arguments]
        self.process = subprocess.Popen(
            words,
            env=child_environment(Path(__file__).parents[1]),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        assert self.process.stdout is not None
        if self.process.stdout.readline().strip() != b"ready":
            _, errors = self.process.communicate()
            self._folder.cleanup()
            lines = errors.decode().strip().splitlines() or ["the emulator did not start"]
            raise BusError(lines[-1])
        self.control = Control(self.control_path)

    def send(self, do: str, **arguments: Any) -> dict[str, Any]:
        """Send one command on the control socket; ControlError with the reason when refused."""
        return self.control.send(do, **arguments)

    def close(self, kill: bool = False) -> None:
        """End or kill the process."""
        if kill:
            self.process.kill()
        else:
            self.process.terminate()
        self.process.communicate()
        self.control.close()
        self._folder.cleanup()


class EmulatedBus(AbstractContextManager):
    """Namespace and emulator; `client()` returns a matching `BusClient`."""

    def __init__(
        self,
        bus_file: str | Path,
        rate_hz: int = 0,
        seed: int = 1,
        plant: str = "simulated",
        options: Mapping[str, str] | None = None,
        wait_for_nodes: bool = False,
    ) -> None:
        """rate_hz: 0: as in the bus file; plant: 'simulated' or module:function; options: options
        of the plant ('simulated' has tire, preset, config); wait_for_nodes: a cycle waits for the
        nodes' answers to the last one. NamespaceError when no namespace can be made."""
        self.bus_file = bus_file
        self.rate_hz = rate_hz
        self.node_timeout_ms = WAIT_MS if wait_for_nodes else 0.0
        self.namespace = BenchNamespace()
        words = ["--seed", str(seed), "--plant", plant, "--max-age-ms", str(REPLY_TIMEOUT_MS)]
        words += ["--master-timeout-ms", str(2.0 * self.node_timeout_ms)]
        words += ["--rate", str(rate_hz)] if rate_hz else []
        for key, value in (options or {}).items():
            words += ["--option", f"{key}={value}"]
        try:
            self.emulator = EmulatorProcess(self.namespace, bus_file, words)
        except BusError:
            self.namespace.close()
            raise

    def client(
        self,
        fifo: bool = True,
        on_event: Callable[[dict[str, Any]], None] | None = None,
        batch: int = 1,
    ) -> BusClient:
        """A client, not started yet. batch: the nodes answer the last of this many cycles."""
        return BusClient(
            self.bus_file, MASTER, rate_hz=self.rate_hz, fifo=fifo, slip=True, batch=batch,
            reply_timeout_ms=REPLY_TIMEOUT_MS, node_timeout_ms=self.node_timeout_ms,
            launch=self.namespace.enter, on_event=on_event,
        )  # fmt: skip

    def operate(self, switch: str, *arguments: Any) -> None:
        """Use a switch of the plant's operator, for instance operate('plank', 1, True)."""
        self.emulator.send("operator", name=switch, arguments=list(arguments))

    def close(self) -> None:
        """End the emulator and release the namespace."""
        self.emulator.close()
        self.namespace.close()

    def __exit__(self, *_: object) -> None:
        self.close()
