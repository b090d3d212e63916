# SPDX-License-Identifier: Apache-2.0
"""Sends jobs to a worker process from the event loop of the pages."""

from __future__ import annotations

import asyncio
import json
import os
import sys
from pathlib import Path
from typing import Any

from flatplank_data.errors import FlatplankError
from flatplank_data.progress import Progress
from flatplank_hw.process import END_WITH_PARENT

LINE = 64 * 1024 * 1024
"""largest length of an answer [bytes]"""


class ConsentNeeded(FlatplankError):
    """The model names an effect file that the user has not allowed to run."""

    def __init__(self, words: str, file: str, text: str, digest: str) -> None:
        super().__init__(words)
        self.file, self.text, self.digest = file, text, digest


class Analysis:
    """One worker process; it does one request at a time, further ones wait. Cancelling the task of
    a request ends the process; waiting requests use a new one."""

    def __init__(self, log: Path | None = None) -> None:
        self._log = log
        self._process: asyncio.subprocess.Process | None = None
        self._lock = asyncio.Lock()

    async def ask(self, job: str, progress: Progress | None = None, /, **arguments: Any) -> Any:
        """Do a job and return its result; ValueError with the reason on failure,
        ConsentNeeded where the user must allow an effect file first."""
        report_progress = progress or (lambda _text, _share: None)
        if self._lock.locked():
            report_progress("waiting until other work is done", 0.0)
        async with self._lock:
            try:
                return await self._asked(job, report_progress, arguments)
            except asyncio.CancelledError:
                self.close()
                raise

    async def _asked(self, job: str, report_progress: Progress, arguments: dict[str, Any]) -> Any:
        process = await self._started()
        assert process.stdin and process.stdout
        process.stdin.write(json.dumps({"do": job, "with": arguments}).encode() + b"\n")
        await process.stdin.drain()
        while line := await process.stdout.readline():
            message = json.loads(line)
            if "progress" in message:
                report_progress(message["progress"], message["share"])
            elif "consent" in message:
                raise ConsentNeeded(message["error"], **message["consent"])
            elif "error" in message:
                raise ValueError(message["error"])
            else:
                return message["result"]
        await process.wait()
        raise ValueError(f"the analysis has ended with code {process.returncode}; see {self._log}")

    def close(self) -> None:
        """End the process; the next request starts a new one."""
        process, self._process = self._process, None
        if process is not None and process.returncode is None:
            process.terminate()

    async def _started(self) -> asyncio.subprocess.Process:
        if self._process is None or self._process.returncode is not None:
            errors = open(self._log, "ab") if self._log else None  # noqa: SIM115
            try:
                self._process = await asyncio.create_subprocess_exec(
                    sys.executable, "-m", "flatplank_panel.analysis.worker",
                    stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE, stderr=errors,
                    limit=LINE, start_new_session=True,
                    env={**os.environ, END_WITH_PARENT: str(os.getpid())},
                )  # fmt: skip
            finally:
                if errors:
                    errors.close()
        return self._process
