# SPDX-License-Identifier: Apache-2.0
"""Reports troubles of a node: once in the log, and in /diagnostics while they last."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Collection, Coroutine, Mapping
from inspect import iscoroutinefunction
from typing import Any, NamedTuple

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from flatplank_hw.troubles import TROUBLES, Level, Trouble

OF_NODES = "troubles"
"""topic with the troubles of each node; the owner of the bus joins them into /diagnostics"""

SHOWN = 10.0
"""time for which an occurrence stays in /diagnostics and is not logged again [s]"""


class _Present(NamedTuple):
    trouble: Trouble
    detail: str
    until: float
    """end by the monotonic clock [s]; infinite: until `end` is called"""

    def line(self) -> str:
        return self.trouble.line(self.detail)


class Reporter:
    """Present troubles of one node; may be called from several threads."""

    def __init__(self, name: str, logger: Any, changed: Callable[[], None]) -> None:
        """changed: called when there is something new to publish."""
        self._name, self._logger, self._changed = name, logger, changed
        self._present: dict[tuple[str, str], _Present] = {}
        self._lock = threading.RLock()

    def set_lasting(self, wanted: Mapping[str, str], among: Collection[str]) -> None:
        """Begin the troubles in `wanted` (name -> detail) and end all others of `among`."""
        with self._lock:
            lasting = [name for name, of in self._present if not of]
        for name in lasting:
            if name in among and name not in wanted:
                self.end(name)
        for name, detail in wanted.items():
            self.begin(name, detail)

    def begin(self, name: str, detail: str = "", of: str = "") -> None:
        """Begin a lasting trouble; a repeated call updates the detail and logs nothing.

        `of`: source of the trouble, when several may have it at a time.
        """
        key = (name, of)
        with self._lock:
            old = self._present.get(key)
            self._present[key] = _Present(TROUBLES[name], detail, float("inf"))
        if old is None:
            self._log(TROUBLES[name], TROUBLES[name].line(detail))
            self._changed()

    def end(self, name: str, of: str = "") -> None:
        """End a lasting trouble."""
        with self._lock:
            old = self._present.pop((name, of), None)
        if old is not None:
            if old.trouble.level > Level.OK:
                self._logger.info(" ".join(["over:", old.trouble.text, of]).rstrip())
            self._changed()

    def report_occurrence(self, name: str, detail: str = "") -> None:
        """Report an occurrence; a repetition while it is shown is not logged again."""
        key = (name, detail)
        with self._lock:
            old = self._present.get(key)
            self._present[key] = _Present(TROUBLES[name], detail, time.monotonic() + SHOWN)
        if old is None:
            self._log(TROUBLES[name], TROUBLES[name].line(detail))
            self._changed()

    def status(self, values: Mapping[str, Any]) -> DiagnosticStatus:
        """Status for /diagnostics, the worst trouble first, with the `values` of the node."""
        with self._lock:
            now = time.monotonic()
            self._present = {k: p for k, p in self._present.items() if p.until > now}
            present = sorted(self._present.values(), key=lambda p: -p.trouble.level)
        names = ", ".join(dict.fromkeys(p.trouble.name for p in present))
        shown = {"troubles": names, **values} if names else values
        return DiagnosticStatus(
            level=bytes([max((p.trouble.level for p in present), default=Level.OK)]),
            name=self._name,
            message=" | ".join(p.line() for p in present) or "ok",
            values=[KeyValue(key=str(k), value=str(v)) for k, v in shown.items()],
        )

    def _log(self, trouble: Trouble, line: str) -> None:
        # a ROS logger needs one place in the code per severity
        if trouble.level >= Level.ERROR:
            self._logger.error(line)
        elif trouble.level == Level.WARN:
            self._logger.warning(line)
        else:
            self._logger.info(line)


class Collector:
    """Collects the latest status of each node for one message."""

    SILENT = 10.0
    """a node without messages for this time is reported as silent [s]"""
    FORGOTTEN = 300.0
    """a node without messages for this time is forgotten [s]"""

    def __init__(self) -> None:
        self._latest: dict[str, tuple[DiagnosticStatus, float]] = {}
        self._lock = threading.Lock()

    def store_status(self, message: DiagnosticArray) -> None:
        """Store the status messages of a node."""
        now = time.monotonic()
        with self._lock:
            self._latest.update({status.name: (status, now) for status in message.status})

    def silence_by_node(self) -> dict[str, bool]:
        """Node that has published -> true when it is silent now."""
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
        """Status of each node that has published."""
        with self._lock:
            return [status for _, (status, _) in sorted(self._latest.items())]


def reporting_refusals(reporter: Reporter, name: str, callback: Callable) -> Callable:
    """Wrap the callback of a service so that its refusals are reported."""

    def checked(response: Any) -> Any:
        accepted = getattr(response, "accepted", getattr(response, "success", True))
        if not accepted:
            reason = getattr(response, "reason", "") or getattr(response, "message", "")
            reporter.report_occurrence("refused", f"{name}: {reason}")
        return response

    async def reported(request: Any, response: Any) -> Any:
        return checked(await callback(request, response))

    def asked(request: Any, response: Any) -> Any | Coroutine:
        return checked(callback(request, response))

    return reported if iscoroutinefunction(callback) else asked
