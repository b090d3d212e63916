# SPDX-License-Identifier: Apache-2.0
"""A part of a long job in a process of its own, beside the others; its steps are printed when it
is their turn."""

from __future__ import annotations

import multiprocessing
import queue
import signal
import threading
import time
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any, Protocol

from flatplank_analysis.parallel import end_with_parent
from flatplank_data.errors import FlatplankError
from flatplank_sim.cli.step_printer import StepPrinter

STEP, PROGRESS, RESULT, ERROR = "step", "progress", "result", "error"


class Steps(Protocol):
    """What a part of a long job tells."""

    def step(self, text: str) -> None:
        """Begin a new step."""

    def print_progress(self, text: str) -> None:
        """Tell the progress of the step."""

    def count(self, done: int, total: int, name: str) -> None:
        """Tell the progress of many equal tasks."""


class _SentSteps:
    """Sends its steps to the process that prints them, each with its time."""

    def __init__(self, send: Callable[[tuple[str, Any, float]], None]) -> None:
        self._send = send

    def tell(self, kind: str, content: Any) -> None:
        self._send((kind, content, time.monotonic()))

    def step(self, text: str) -> None:
        self.tell(STEP, text)

    def print_progress(self, text: str) -> None:
        self.tell(PROGRESS, text)

    def count(self, done: int, total: int, name: str) -> None:
        if done == total:
            self.print_progress(f"{done}/{total} {name}")


def _work(connection: Connection, function: Callable[..., Any], arguments: tuple) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C ends the parent, and that this process
    end_with_parent()
    steps = _SentSteps(connection.send)
    try:
        steps.tell(RESULT, function(*arguments, steps))
    except Exception as error:
        steps.tell(ERROR, error)


class Beside:
    """Calls `function(*arguments, steps)` in a new process; leaving the context ends it."""

    def __init__(self, function: Callable[..., Any], *arguments: Any) -> None:
        context = multiprocessing.get_context("spawn")
        self._connection, theirs = context.Pipe(duplex=False)
        self._process = context.Process(target=_work, args=(theirs, function, arguments))
        self._told: queue.Queue[tuple[str, Any, float]] = queue.Queue()
        self._process.start()
        theirs.close()
        threading.Thread(target=self._collect, daemon=True).start()

    def __enter__(self) -> Beside:
        return self

    def __exit__(self, *_error: object) -> None:
        self._process.terminate()
        self._process.join()

    def _collect(self) -> None:
        try:
            while True:
                self._told.put(self._connection.recv())
        except (EOFError, OSError):
            what = FlatplankError("its process has ended (out of memory?)", "demo", "start again")
            self._told.put((ERROR, what, time.monotonic()))

    def print_steps(self, printer: StepPrinter) -> Any:
        """Print the steps up to the end of the process; returns the result. The errors of the
        function are raised here."""
        while True:
            kind, content, at = self._told.get()
            if kind == STEP:
                printer.step(content, at)
            elif kind == PROGRESS:
                printer.print_progress(content)
            elif kind == ERROR:
                raise content
            else:
                printer.end_step(at)
                return content
