# SPDX-License-Identifier: Apache-2.0
"""Control socket of the emulator: one JSON object per line in, one out."""

from __future__ import annotations

import json
import os
import socket
from collections.abc import Callable
from pathlib import Path
from typing import Any

from flatplank_data.errors import FlatplankError

Handler = Callable[[dict[str, Any]], dict[str, Any]]


class ControlServer:
    """Server on a Unix stream socket, polled from the runner's loop; never blocks it."""

    def __init__(self, path: str | Path, handler: Handler) -> None:
        self.path = str(path)
        self._handler = handler
        if os.path.exists(self.path):
            os.unlink(self.path)
        self._server = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self._server.bind(self.path)
        self._server.listen(4)
        self._server.setblocking(False)
        self._clients: dict[socket.socket, bytes] = {}

    def filenos(self) -> list[int]:
        """File descriptor for poll; clients are read in every round anyway."""
        return [self._server.fileno()]

    def poll(self) -> None:
        """Serve pending connections and requests."""
        try:
            client, _ = self._server.accept()
            client.setblocking(False)
            self._clients[client] = b""
        except BlockingIOError:
            pass
        for client in list(self._clients):
            self._serve(client)

    def _serve(self, client: socket.socket) -> None:
        try:
            data = client.recv(65536)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:
            client.close()
            del self._clients[client]
            return
        *lines, self._clients[client] = (self._clients[client] + data).split(b"\n")
        for line in lines:
            answer = self._answer(line)
            try:
                client.sendall(json.dumps(answer).encode() + b"\n")
            except OSError:
                client.close()
                del self._clients[client]
                return

    def _answer(self, line: bytes) -> dict[str, Any]:
        try:
            request = json.loads(line)
            if not isinstance(request, dict):
                raise ValueError("a request is a JSON object")
            return {"ok": True, **self._handler(request)}
        except (ValueError, TypeError) as error:
            return {"ok": False, "reason": str(error)}

    def close(self) -> None:
        """Close and remove the socket."""
        for client in self._clients:
            client.close()
        self._server.close()
        if os.path.exists(self.path):
            os.unlink(self.path)


class ControlError(FlatplankError):
    """The emulator refused a request."""


class Control:
    """Client of the control socket: `Control(path).send("drop", frames=3)`."""

    def __init__(self, path: str | Path, timeout: float = 5.0) -> None:
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self._socket.settimeout(timeout)
        self._socket.connect(str(path))
        self._rest = b""

    def send(self, do: str, **arguments: Any) -> dict[str, Any]:
        """Send a request; returns the answer, ControlError with the reason when refused."""
        self._socket.sendall(json.dumps({"do": do, **arguments}).encode() + b"\n")
        while b"\n" not in self._rest:
            try:
                data = self._socket.recv(65536)
            except TimeoutError:
                self.close()  # a late answer must not be taken for that of the next request
                raise
            if not data:
                raise ConnectionError("the emulator is gone")
            self._rest += data
        line, self._rest = self._rest.split(b"\n", 1)
        answer = json.loads(line)
        if not answer.pop("ok"):
            raise ControlError(answer["reason"])
        return answer

    def close(self) -> None:
        """Close the connection."""
        self._socket.close()
