# SPDX-License-Identifier: Apache-2.0
"""Ask a worker process from the event loop of the pages."""

from __future__ import annotations

import asyncio
import json
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from flatplank_hw.parent import END_WITH_PARENT

LINE = 64 * 1024 * 1024
Progress = Callable[[str, float], None]


class Cancelled(ValueError):
    """The operator has cancelled the work."""


class Analysis:
    """One worker; one request at a time, further ones wait."""

    def __init__(self, log: Path | None = None) -> None:
        self._log = log
        self._process: asyncio.subprocess.Process | None = None
        self._lock = asyncio.Lock()
        self._cancelled = False

    @property
    def busy(self) -> bool:
        return self._lock.locked()

    @property
    def alive(self) -> bool:
        """The process is there, with what was opened in it."""
        return self._process is not None and self._process.returncode is None

    async def ask(self, job: str, progress: Progress | None = None, /, **arguments: Any) -> Any:
        """Result of a job; ValueError with the reason when it cannot be done."""
        async with self._lock:
            self._cancelled = False
            process = await self._started()
            assert process.stdin and process.stdout
            process.stdin.write(json.dumps({"do": job, "with": arguments}).encode() + b"\n")
            await process.stdin.drain()
            while line := await process.stdout.readline():
                message = json.loads(line)
                if "progress" in message:
                    if progress:
                        progress(message["progress"], message["share"])
                elif "error" in message:
                    raise ValueError(message["error"])
                else:
                    return message["result"]
            await process.wait()
            if self._cancelled:
                raise Cancelled("cancelled")
            raise ValueError(
                f"the analysis has ended with code {process.returncode}; see {self._log}"
            )

    def cancel(self) -> None:
        """End the work that is under way; the next request starts a new process."""
        if self.busy:
            self._cancelled = True
            self.close()

    def close(self) -> None:
        if self.alive:
            self._process.terminate()

    async def _started(self) -> asyncio.subprocess.Process:
        if not self.alive:
            errors = open(self._log, "ab") if self._log else None  # noqa: SIM115
            try:
                self._process = await asyncio.create_subprocess_exec(
                    sys.executable,
                    "-m",
                    "flatplank_control.panel.analysis.worker",
                    stdin=asyncio.subprocess.PIPE,
                    stdout=asyncio.subprocess.PIPE,
                    stderr=errors,
                    limit=LINE,
                    start_new_session=True,
                    env={**os.environ, END_WITH_PARENT: str(os.getpid())},
                )
            finally:
                if errors:
                    errors.close()
        return self._process
