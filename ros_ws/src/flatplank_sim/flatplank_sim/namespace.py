# SPDX-License-Identifier: Apache-2.0
"""A network namespace with a veth pair: the wire between master and emulator, gone when it is
closed.

Works as root, or without any rights where user namespaces are allowed.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from typing import TypeVar

MASTER, EMULATOR = "veth0", "veth1"
_HOLD = (
    "ip link add {0} type veth peer name {1} && ip link set {0} up && ip link set {1} up"
    " && echo ready && exec cat"
)


Self = TypeVar("Self", bound="Closed")


class NamespaceError(ValueError):
    """No namespace can be had here: one line with the reason."""


class Closed:
    """Is closed at the end of a `with` block."""

    def close(self) -> None:
        """Let go what is held."""
        raise NotImplementedError

    def __enter__(self: Self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class BenchNamespace(Closed):
    """Holds the namespace open by a process that waits for the end of its input."""

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
        """words in front of a command that shall run inside"""

    def run(self, *command: str) -> None:
        """A command inside, for instance `ip link set veth0 down`."""
        subprocess.run([*self.enter, *command], check=True, capture_output=True)

    def close(self) -> None:
        """Let it go; what still runs inside keeps it alive."""
        self._holder.communicate()
