# SPDX-License-Identifier: Apache-2.0
"""Journal of a campaign, line by line on disk; with it a campaign resumes after a crash or a
break."""

from __future__ import annotations

import errno
import fcntl
import json
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from flatplank_data.journals import end_of_lines, read_lines
from flatplank_data.run_record import load_record

GAUGE = (0.3, 6.0)
"""range of plausible tire pressures [bar]"""


@dataclass
class RunEnd:
    """How a run of the plan ended."""

    files: list[str] = field(default_factory=list)
    """files of all attempts"""
    valid_file: str = ""
    """file of the last finished attempt; that of an earlier one where the last one was stopped"""
    record: dict[str, Any] = field(default_factory=dict)
    """run record of that file"""
    attempts: int = 0
    final: bool = False
    """no further attempt is needed"""
    skipped: bool = False
    facts: dict[str, Any] = field(default_factory=dict)
    """findings, radius, Fx profile"""


class Journal:
    """Append-only journal; each line is on disk before the bench continues."""

    def __init__(self, path: Path, name: str, digest: str) -> None:
        """Open or create a journal; ValueError when the file belongs to another plan."""
        self.path = path
        self.done: dict[str, RunEnd] = {}
        self.interrupted: str = ""
        """key of a run that was begun and not ended"""
        self.travel = 0.0
        """road that loaded tires have rolled in all ended runs, kept or not [m]"""
        lines = read_lines(path)
        if lines and lines[0].get("digest") != digest:
            raise ValueError(
                f"{path}: belongs to another version of the plan ({lines[0].get('name')}); "
                "give another folder, or the plan as it was"
            )
        for line in lines[1:]:
            self._take(line)
        path.parent.mkdir(parents=True, exist_ok=True)
        if not lines:
            self._write({"event": "plan", "name": name, "digest": digest})

    def begin(self, key: str, attempt: int) -> None:
        self._write({"event": "begin", "run": key, "attempt": attempt})
        self.interrupted = key

    def end(
        self, key: str, file: str, ok: bool, final: bool,
        facts: Mapping[str, Any], record: Mapping[str, Any],
    ) -> None:  # fmt: skip
        """Enter the end of a run. `final`: no further attempt follows; `record`: fields of its run
        record."""
        line = {"event": "end", "run": key, "file": file, "ok": ok, "final": final}
        self._write({**line, "facts": dict(facts), "record": dict(record)})

    def skip(self, key: str, why: str) -> None:
        self._write({"event": "skip", "run": key, "why": why})

    def schedule_again(self, key: str) -> None:
        """Schedule a run once more; the existing result stays valid until then."""
        self._write({"event": "again", "run": key})

    def needs_repeat(self, key: str) -> bool:
        """True when the run was skipped or all its attempts were flagged."""
        done = self.done.get(key)
        if done is None:
            return False
        return done.skipped or (done.final and not done.facts.get("good", True))

    def finished(self, key: str) -> bool:
        """True when the run needs no further attempt."""
        return key in self.done and (self.done[key].final or self.done[key].skipped)

    def _write(self, line: Mapping[str, Any]) -> None:
        write_line(self.path, line)
        self._take(line)

    def _take(self, line: Mapping[str, Any]) -> None:
        key = line.get("run", "")
        if line["event"] == "begin":
            self.interrupted = key
        elif line["event"] == "skip":
            self.done.setdefault(key, RunEnd()).skipped = True
        elif line["event"] == "again":
            entry = self.done[key]
            entry.final = entry.skipped = False
        elif line["event"] == "end":
            entry = self.done.setdefault(key, RunEnd())
            entry.files.append(line["file"])
            entry.attempts += 1
            entry.final = line["final"]
            entry.facts = dict(line["facts"]) | {"good": line["ok"]}
            if entry.final and not entry.facts.get("stopped"):
                entry.valid_file, entry.record = line["file"], dict(line.get("record", {}))
            self.travel += entry.facts.get("travel", 0.0)
            self.interrupted = ""


def write_note(path: Path, text: str) -> None:
    """Enter a remark of the operator."""
    if text.strip():
        write_line(path, {"event": "note", "text": text.strip()})


def pressure_after(path: Path, text: str) -> str:
    """Enter the pressure measured after the latest run [bar] into the journal and that run's
    record.

    Returns the name of the run; ValueError when `text` is no pressure or no run is over.
    """
    low, high = GAUGE
    try:
        bar = float(text)
    except ValueError:
        bar = math.nan
    if not low <= bar <= high:
        raise ValueError(f"pressure '{text.strip()}': give {low:g} .. {high:g} bar")
    files = [line["file"] for line in read_lines(path) if line["event"] == "end"]
    if not files:
        raise ValueError(f"{path}: no run is over yet; give its pressure then")
    record = load_record(path.parent / files[-1])
    session = {**record.parameters.get("session", {}), "pressure_after": bar}
    changed = record.with_changes(parameters={**record.parameters, "session": session})
    changed.save(path.parent / files[-1])
    write_line(path, {"event": "pressure", "file": files[-1], "bar": bar})
    return str(files[-1])


def write_line(path: Path, line: Mapping[str, Any]) -> None:
    """Append a line; it is on disk when this returns.

    A torn last line of a program that was killed is removed first, and a line that could not be
    written whole is taken back. Lines of several programs do not mix.
    """
    text = json.dumps(line).encode() + b"\n"
    with open(path, "ab", buffering=0) as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        end = end_of_lines(path)
        file.truncate(end)
        try:
            if file.write(text) < len(text):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))
            os.fsync(file.fileno())
        except OSError:
            file.truncate(end)
            raise
