# SPDX-License-Identifier: Apache-2.0
"""Raw Ethernet port of the emulator: EtherCAT frames with their kernel time stamps."""

from __future__ import annotations

import fcntl
import socket
import struct
import time

ETHERCAT = 0x88A4
SO_TIMESTAMPNS = 35
IFF_UP = 0x1
SIOCGIFFLAGS, SIOCSIFFLAGS = 0x8913, 0x8914
NAME_LIMIT = 15


class PortError(ValueError):
    """The interface cannot be used: one line with the remedy."""


class Port:
    """Bound to one interface."""

    def __init__(self, interface: str) -> None:
        if len(interface.encode()) > NAME_LIMIT:
            raise PortError(f"interface '{interface}': names have at most {NAME_LIMIT} characters")
        self.interface = interface
        try:
            self.socket = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(ETHERCAT))
        except PermissionError:
            raise PortError(
                "no permission for raw Ethernet; run as root or inside 'unshare -Urn', or give the"
                " interpreter CAP_NET_RAW (sudo setcap cap_net_raw+ep $(readlink -f python3))"
            ) from None
        try:
            self.socket.bind((interface, ETHERCAT))
        except OSError as error:
            self.socket.close()
            raise PortError(
                f"interface '{interface}': {error.strerror}; 'ip link' lists what there is"
            ) from None
        self.socket.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)
        self.socket.setblocking(False)

    def fileno(self) -> int:
        """For poll."""
        return self.socket.fileno()

    def receive(self) -> tuple[bytes, int] | None:
        """Next frame and its age [ns]; None: nothing there (or the link is down)."""
        try:
            frame, ancillary, _, _ = self.socket.recvmsg(2048, 64)
        except OSError:
            return None
        age = 0
        for level, kind, data in ancillary:
            if level == socket.SOL_SOCKET and kind == SO_TIMESTAMPNS:
                seconds, nanoseconds = struct.unpack("qq", data[:16])
                age = time.time_ns() - (seconds * 1_000_000_000 + nanoseconds)
        return frame, age

    def send(self, frame: bytes | bytearray) -> None:
        """A frame to the master; a dead link swallows it."""
        try:
            self.socket.send(frame)
        except OSError:
            return

    def set_link(self, up: bool) -> None:
        """Take the interface down or up, as pulling the plug does."""
        name = self.interface.encode().ljust(16, b"\0")
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as control:
            raw = fcntl.ioctl(control, SIOCGIFFLAGS, name + bytes(24))
            flags = struct.unpack_from("H", raw, 16)[0]
            flags = flags | IFF_UP if up else flags & ~IFF_UP
            fcntl.ioctl(control, SIOCSIFFLAGS, name + struct.pack("H", flags) + bytes(22))

    def close(self) -> None:
        """Give the interface back."""
        self.socket.close()
