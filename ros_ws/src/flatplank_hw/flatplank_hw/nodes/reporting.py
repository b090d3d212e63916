# SPDX-License-Identifier: Apache-2.0
"""Troubles of a node: each occurrence once in the log, and as long as it lasts in /diagnostics."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Collection, Coroutine, Mapping
from inspect import iscoroutinefunction
from typing import Any, NamedTuple

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from flatplank_hw.troubles import TROUBLES, Level, Trouble

OF_NODES = "/troubles"
"""what nodes say of themselves; the owner of the bus makes one message of all of them"""

SHOWN = 10.0
"""an occurrence stays in /diagnostics so long, and is not logged again meanwhile [s]"""


class _Present(NamedTuple):
    trouble: Trouble
    detail: str
    until: float
    """[s] of the monotonic clock; infinite: until it is over"""

    def line(self) -> str:
        return self.trouble.line(self.detail)


class Reporter:
    """What is wrong with one node; may be told from several threads."""

    def __init__(self, name: str, logger: Any, changed: Callable[[], None]) -> None:
        """`changed` is called when there is something new to publish."""
        self._name, self._logger, self._changed = name, logger, changed
        self._present: dict[tuple[str, str], _Present] = {}
        self._lock = threading.RLock()

    def now(self, wanted: Mapping[str, str], among: Collection[str]) -> None:
        """Of the troubles `among`, just these last now: name -> detail."""
        with self._lock:
            lasting = [name for name, of in self._present if not of]
        for name in lasting:
            if name in among and name not in wanted:
                self.end(name)
        for name, detail in wanted.items():
            self.begin(name, detail)

    def begin(self, name: str, detail: str = "", of: str = "") -> None:
        """A trouble that lasts; told anew, its detail is kept up to date and nothing is logged.

        `of`: whose it is, when several may have it at a time.
        """
        key = (name, of)
        with self._lock:
            old = self._present.get(key)
            self._present[key] = _Present(TROUBLES[name], detail, float("inf"))
        if old is None:
            self._log(TROUBLES[name], TROUBLES[name].line(detail))
            self._changed()

    def end(self, name: str, of: str = "") -> None:
        """It is over."""
        with self._lock:
            old = self._present.pop((name, of), None)
        if old is not None:
            if old.trouble.level > Level.OK:
                self._logger.info(" ".join(["over:", old.trouble.text, of]).rstrip())
            self._changed()

    def happened(self, name: str, detail: str = "") -> None:
        """An occurrence; the same again while it is shown is the same one."""
        key = (name, detail)
        with self._lock:
            old = self._present.get(key)
            self._present[key] = _Present(TROUBLES[name], detail, time.monotonic() + SHOWN)
        if old is None:
            self._log(TROUBLES[name], TROUBLES[name].line(detail))
            self._changed()

    def status(self, values: Mapping[str, Any]) -> DiagnosticStatus:
        """For /diagnostics: the worst first; `values` are the node's own."""
        with self._lock:
            now = time.monotonic()
            self._present = {k: p for k, p in self._present.items() if p.until > now}
            present = sorted(self._present.values(), key=lambda p: -p.trouble.level)
        names = ", ".join(dict.fromkeys(p.trouble.name for p in present))
        told = {"troubles": names, **values} if names else values
        return DiagnosticStatus(
            level=bytes([max((p.trouble.level for p in present), default=Level.OK)]),
            name=self._name,
            message=" | ".join(p.line() for p in present) or "ok",
            values=[KeyValue(key=str(k), value=str(v)) for k, v in told.items()],
        )

    def _log(self, trouble: Trouble, line: str) -> None:
        # a logger of ROS wants one place in the code per severity
        if trouble.level >= Level.ERROR:
            self._logger.error(line)
        elif trouble.level == Level.WARN:
            self._logger.warning(line)
        else:
            self._logger.info(line)


class Collector:
    """The latest of what nodes say of themselves, for one message with all of it."""

    SILENT = 10.0
    """a node from which nothing has come for so long is told [s]"""
    FORGOTTEN = 300.0
    """[s]"""

    def __init__(self) -> None:
        self._latest: dict[str, tuple[DiagnosticStatus, float]] = {}
        self._lock = threading.Lock()

    def hear(self, message: DiagnosticArray) -> None:
        now = time.monotonic()
        with self._lock:
            self._latest.update({status.name: (status, now) for status in message.status})

    def silent(self) -> dict[str, bool]:
        """Every node that has published, and whether it is silent now."""
        now = time.monotonic()
        with self._lock:
            found = {name: now - at > self.SILENT for name, (_, at) in self._latest.items()}
            for name, (status, at) in tuple(self._latest.items()):
                if found[name]:
                    status.level, status.message, status.values = DiagnosticStatus.STALE, "", []
                if now - at > self.FORGOTTEN:
                    del self._latest[name]
                    found[name] = False
        return found

    def statuses(self) -> list[DiagnosticStatus]:
        """Of every node that has published."""
        with self._lock:
            return [status for _, (status, _) in sorted(self._latest.items())]


def telling(reporter: Reporter, name: str, callback: Callable) -> Callable:
    """A service's callback whose refusals are told."""

    def told(response: Any) -> Any:
        accepted = getattr(response, "accepted", getattr(response, "success", True))
        if not accepted:
            reason = getattr(response, "reason", "") or getattr(response, "message", "")
            reporter.happened("refused", f"{name}: {reason}")
        return response

    async def asked_and_waited(request: Any, response: Any) -> Any:
        return told(await callback(request, response))

    def asked(request: Any, response: Any) -> Any | Coroutine:
        return told(callback(request, response))

    return asked_and_waited if iscoroutinefunction(callback) else asked
