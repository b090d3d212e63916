# SPDX-License-Identifier: Apache-2.0
"""Asks the process that parses; it is started with the first file, and again after a crash."""

from __future__ import annotations

import atexit
import os
import signal
import subprocess
import sys
import threading
from typing import Any

from flatplank_data.guard import DamagedError
from flatplank_data.native.child import HEAD, LENGTH
from flatplank_data.native.values import from_bytes


class _Parser:
    """One process, used by one program; a fork of the program starts its own."""

    def __init__(self) -> None:
        self._forget()
        self._of_parent: list[subprocess.Popen | None] = []
        os.register_at_fork(after_in_child=self._forked)
        atexit.register(self.stop)

    def _forget(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._lock = threading.Lock()

    def _forked(self) -> None:
        self._of_parent.append(self._process)
        self._forget()

    def parse(self, name: str, data: bytes) -> Any:
        """Values that the parser `name` finds in a file. Raises DamagedError."""
        with self._lock:
            process = self._process = self._process or _started()
            assert process.stdin is not None and process.stdout is not None
            try:
                process.stdin.write(HEAD.pack(name.encode(), len(data)))
                process.stdin.write(data)
                process.stdin.flush()
                (size,) = LENGTH.unpack(process.stdout.read(LENGTH.size).ljust(8, b"\xff"))
                answer = process.stdout.read(size) if size < 2**63 else b""
                complete = len(answer) == size
            except OSError:
                complete = False
            if not complete:
                raise DamagedError(f"its parser {self._end()}")
        found = from_bytes(answer)
        if "error" in found:
            raise DamagedError(found["error"])
        return found["values"]

    def _end(self) -> str:
        """End the process; how it ended."""
        process, self._process = self._process, None
        if process is None:
            return "did not start"
        for pipe in (process.stdin, process.stdout):
            try:
                if pipe:
                    pipe.close()
            except OSError:
                pass
        code = process.wait()
        return f"ended with {signal.Signals(-code).name if code < 0 else f'code {code}'}"

    def stop(self) -> None:
        """End the process; the next file starts another one."""
        with self._lock:
            self._end()


def _started() -> subprocess.Popen[bytes]:
    path = os.pathsep.join(p for p in sys.path if p)
    return subprocess.Popen(
        [sys.executable, "-m", "flatplank_data.native.child"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env={**os.environ, "PYTHONPATH": path, "OPENBLAS_NUM_THREADS": "1"},
    )


_PARSER = _Parser()
parse = _PARSER.parse
stop = _PARSER.stop
