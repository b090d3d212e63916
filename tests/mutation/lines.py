# SPDX-License-Identifier: Apache-2.0
"""Which test runs which line: a pytest plugin that writes it, and the tests of a line.

`pytest -p lines` with FLATPLANK_LINES=FOLDER:FILE writes FILE for the code below FOLDER. Lines of
other processes and of machine code are not seen.
"""

from __future__ import annotations

import json
import os
import sys
import threading
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

VARIABLE = "FLATPLANK_LINES"


class Tracer:
    """Lines below a folder that ran since the last look."""

    def __init__(self, top: str) -> None:
        self._top = top
        self._seen: set[tuple[str, int]] = set()

    def start(self) -> None:
        """From now on, in new threads, too."""
        self._seen.clear()
        threading.settrace(self._call)
        sys.settrace(self._call)

    def stop(self) -> list[tuple[str, int]]:
        """(file, line), the file relative to the folder."""
        sys.settrace(None)
        threading.settrace(None)
        return [(os.path.relpath(name, self._top), line) for name, line in self._seen]

    def _call(self, frame, event, argument):
        return self._line if frame.f_code.co_filename.startswith(self._top) else None

    def _line(self, frame, event, argument):
        self._seen.add((frame.f_code.co_filename, frame.f_lineno))
        return self._line


class Plugin:
    """Watches tests and their fixtures."""

    def __init__(self, top: str, out: str) -> None:
        self._tracer, self._out = Tracer(top), Path(out)
        self._tests: dict[str, dict] = {}

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_setup(self, item):
        """What fixtures run belongs to all tests of the file: one of them may ask for it first."""
        with self._watched(item.nodeid, "setup"):
            return (yield)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item):
        """The test itself."""
        with self._watched(item.nodeid, "call"):
            return (yield)

    def pytest_sessionfinish(self):
        """All at the end."""
        self._out.write_text(json.dumps(self._tests))

    def _watched(self, name: str, phase: str):
        return _Watched(self._tracer, self._tests.setdefault(name, {}), phase)


@dataclass
class _Watched:
    tracer: Tracer
    into: dict
    phase: str
    began: float = 0.0

    def __enter__(self) -> None:
        self.began = time.monotonic()
        self.tracer.start()

    def __exit__(self, *_) -> None:
        self.into[self.phase] = self.tracer.stop()
        self.into["seconds"] = self.into.get("seconds", 0.0) + time.monotonic() - self.began


def pytest_configure(config):
    """Only where it is asked for."""
    if VARIABLE in os.environ:
        config.pluginmanager.register(Plugin(*os.environ[VARIABLE].split(":")))


@dataclass(frozen=True)
class Lines:
    """Tests by line, the quickest first."""

    tests: dict[tuple[str, int], tuple[str, ...]]

    @classmethod
    def read(cls, path: Path) -> Lines:
        """Of a file that the plugin wrote."""
        raw = json.loads(path.read_text())
        setups: dict[str, set[tuple[str, int]]] = {}
        for name, test in raw.items():
            own = setups.setdefault(_file(name), set())
            own.update((file, line) for file, line in test["setup"])
        found: dict[tuple[str, int], list[str]] = {}
        for name in sorted(raw, key=lambda n: raw[n]["seconds"]):
            own = {(file, line) for file, line in raw[name].get("call", [])}
            for place in own | setups[_file(name)]:
                found.setdefault(place, []).append(name)
        return cls({place: tuple(names) for place, names in found.items()})

    def of(self, file: str, lines: Iterable[int]) -> tuple[str, ...]:
        """Tests that run one of these lines of a file."""
        return tuple(dict.fromkeys(_each(self.tests, file, lines)))


def _each(tests, file: str, lines: Iterable[int]) -> Iterator[str]:
    for line in lines:
        yield from tests.get((file, line), ())


def _file(name: str) -> str:
    return name.split("::")[0]
