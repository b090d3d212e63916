# SPDX-License-Identifier: Apache-2.0
"""Checks before the first cycle: interface, permission, no second master, and slaves as in the bus
file."""

from __future__ import annotations

import fcntl
import os
import socket
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from flatplank_data.errors import FlatplankError
from flatplank_hw.ethercat.busfile import BusFile


class BusError(FlatplankError):
    """The bus cannot be used; one line states what, where and what to do."""


NAME_LIMIT = 15
ETHERCAT = 0x88A4
SIOCGIFFLAGS = 0x8913
IFF_UP, IFF_RUNNING = 0x01, 0x40


def check_interface(name: str) -> None:
    """Check the name: a long one crashes SOEM, and a missing one gives only 'could not open'."""
    if not name:
        raise BusError("no interface given; 'ip link' lists what there is")
    if len(name.encode()) > NAME_LIMIT:
        raise BusError(
            f"interface '{name}': names have at most {NAME_LIMIT} characters; 'ip link' lists them"
        )
    known = [n for _, n in socket.if_nameindex()]
    if name not in known:
        raise BusError(f"interface '{name}' is not there; found: {', '.join(known) or 'none'}")


def link_trouble(name: str) -> str:
    """Reason why an interface cannot receive; empty when its link is up."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as control:
        raw = fcntl.ioctl(control, SIOCGIFFLAGS, name.encode().ljust(16, b"\0") + bytes(24))
    flags = int.from_bytes(raw[16:18], sys.byteorder)
    if not flags & IFF_UP:
        return f"the interface is down: sudo ip link set {name} up"
    return "" if flags & IFF_RUNNING else "no link: check the cable to the first slave"


def check_permission() -> None:
    """Check for CAP_NET_RAW, which raw sockets need."""
    try:
        socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(ETHERCAT)).close()
    except PermissionError:
        python = os.path.realpath(sys.executable)
        raise BusError(
            "no permission for raw Ethernet; once: sudo setcap"
            f" cap_net_raw,cap_net_admin,cap_sys_nice+ep {python} (or run as root)"
        ) from None


class InterfaceLock:
    """One master per interface (and network namespace), held by a lock on a file."""

    def __init__(self, interface: str, folder: str | Path | None = None) -> None:
        namespace = os.stat("/proc/self/ns/net").st_ino
        folder = Path(folder) if folder else Path(tempfile.gettempdir())
        self.path = folder / f"flatplank-ethercat-{namespace}-{interface}.lock"
        self.interface = interface
        self._file: int | None = None

    def acquire(self) -> None:
        """Take the lock; BusError names the process that has it."""
        try:
            handle = os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
        except OSError as error:
            raise BusError(
                f"lock file {self.path}: {error.strerror}; another user had this interface,"
                " remove the file when no master runs"
            ) from None
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            owner = os.read(handle, 20).decode().strip() or "unknown"
            os.close(handle)
            raise BusError(
                f"interface '{self.interface}' is in use by process {owner}; stop it first"
                " (two masters on one wire corrupt each other)"
            ) from None
        os.ftruncate(handle, 0)
        os.pwrite(handle, f"{os.getpid()}\n".encode(), 0)
        self._file = handle

    def release(self) -> None:
        """Release the lock; the file stays, as removing it would race with the next owner."""
        if self._file is not None:
            os.close(self._file)
            self._file = None


Found = tuple[str, int, int, int]
"""name, vendor, product, revision"""


def check_identities(bus: BusFile, found: Sequence[Found], interface: str) -> None:
    """Refuse a bus that differs from the bus file, and name the first difference."""
    if not found:
        raise BusError(
            f"no slaves on '{interface}'; check the cable, the power of the slaves,"
            " and that the interface is the right one and up"
        )
    for position, (spec, seen) in enumerate(zip(bus.slaves, found, strict=False), 1):
        name, vendor, product, revision = seen
        same = (vendor, product) == (spec.vendor, spec.product)
        if same and (not spec.check_revision or revision == spec.revision):
            continue
        raise BusError(
            f"slave {position} on '{interface}' is '{name}' (vendor 0x{vendor:08X}, product"
            f" 0x{product:08X}, revision 0x{revision:08X}), the bus file has '{spec.name}'"
            f" (0x{spec.vendor:08X}, 0x{spec.product:08X}, 0x{spec.revision:08X}); check the"
            " wiring, or take the slave's identity from its maker's ESI file"
        )
    if len(found) < len(bus.slaves):
        missing = ", ".join(s.name for s in bus.slaves[len(found) :])
        raise BusError(
            f"{len(found)} of {len(bus.slaves)} slaves on '{interface}', missing from"
            f" '{bus.slaves[len(found)].name}' on ({missing}); check cable and power there"
        )
    if len(found) > len(bus.slaves):
        extra = ", ".join(f"'{name}'" for name, *_ in found[len(bus.slaves) :])
        raise BusError(
            f"{len(found)} slaves on '{interface}', the bus file has {len(bus.slaves)};"
            f" unknown: {extra}; add them to the bus file"
        )
