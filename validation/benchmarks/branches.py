# SPDX-License-Identifier: Apache-2.0
"""Runs a calculation once, and from the first use of some constants on once more with others.

What precedes the first use of a constant does not depend on it. So the process forks there: the
child continues with the other values, the parent waits for it and goes on. The calculation must
not have threads of its own.
"""

from __future__ import annotations

import ast
import os
import pickle
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from pathlib import Path
from types import CodeType, FrameType, ModuleType
from typing import Any

PLAIN_DECORATORS = {"property", "staticmethod", "classmethod", "lru_cache", "cached_property"}
"""decorators after which a function still reads its constants when it is called"""

COMPILED = ("numba", ".compiling")
"""modules with the decorators of compiled functions, which contain the numbers that they read"""

Place = tuple[str, str]
"""module and name"""


class Serial:
    """Executor that calls at once, in the same thread."""

    def submit(self, function: Callable, /, *args: Any, **kwargs: Any) -> Future:
        """The call's result, as a future."""
        done: Future = Future()
        done.set_result(function(*args, **kwargs))
        return done


@dataclass(frozen=True)
class Names:
    """Where modules have a constant: by which names, and whether they read it at their import."""

    places: frozenset[Place]
    at_import: bool


class Package:
    """Who imports what from whom in a package; `folder` has its sources."""

    def __init__(self, folder: Path) -> None:
        self._users: dict[Place, list[Place]] = {}
        self._early: dict[str, set[str]] = {}
        self._compiled: set[str] = set()
        for path in sorted(folder.rglob("*.py")):
            parts = path.relative_to(folder).with_suffix("").parts
            self._read(".".join((folder.name, *parts)), ast.parse(path.read_text("utf-8")))

    def _read(self, module: str, tree: ast.Module) -> None:
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and node.module:
                if node.module.endswith(COMPILED):
                    self._compiled.add(module)
                for alias in node.names:
                    place = (node.module, alias.name)
                    self._users.setdefault(place, []).append((module, alias.asname or alias.name))
        self._early[module] = {
            node.id if isinstance(node, ast.Name) else node.attr
            for node in _early(tree)
            if isinstance(node, ast.Name | ast.Attribute) and isinstance(node.ctx, ast.Load)
        }

    def names_of(self, module: str, name: str) -> Names:
        """All places of a constant."""
        places, found = {(module, name)}, [(module, name)]
        while found:
            found = [p for f in found for p in self._users.get(f, ()) if p not in places]
            places.update(found)
        early = any(m in self._compiled or n in self._early[m] for m, n in places)
        return Names(frozenset(places), early)


def _early(node: ast.AST) -> Iterator[ast.AST]:
    """All nodes that run at the import, and functions with other decorators."""
    yield node
    if isinstance(node, ast.Lambda):
        return
    if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
        yield from (part for e in node.decorator_list for part in ast.walk(e))
        defaults = [*node.args.defaults, *filter(None, node.args.kw_defaults)]
        yield from (part for e in defaults for part in ast.walk(e))
        if all(_decorator(d) in PLAIN_DECORATORS for d in node.decorator_list):
            return
    for child in ast.iter_child_nodes(node):
        yield from _early(child)


def _decorator(node: ast.expr) -> str:
    node = node.func if isinstance(node, ast.Call) else node
    return node.attr if isinstance(node, ast.Attribute) else getattr(node, "id", "")


Branch = Sequence[tuple[Names, Any]]
"""a calculation with other values of some constants"""


def run(calculate: Callable[[], Any], branches: Sequence[Branch]) -> tuple[Any, list[Any]]:
    """The result of `calculate`, and that of every branch: None where it never used a constant.

    Results of branches must be fit for `pickle`. RuntimeError if a branch fails.
    """
    fork = _Fork(branches)
    sys.setprofile(fork.called)
    try:
        result = calculate()
    finally:
        sys.setprofile(None)
    if fork.pipe is not None:
        code = 1
        try:
            with open(fork.pipe, "wb") as stream:
                pickle.dump(result, stream)
            code = 0
        finally:
            os._exit(code)
    return result, [fork.results.get(i) for i in range(len(branches))]


class _Fork:
    def __init__(self, branches: Sequence[Branch]) -> None:
        self.pending = dict(enumerate(branches))
        self.results: dict[int, Any] = {}
        self.pipe: int | None = None
        """where a child writes its result"""
        self._seen: set[CodeType] = set()

    def called(self, frame: FrameType, event: str, _: Any) -> None:
        if event != "call" or frame.f_code in self._seen:
            return
        self._seen.add(frame.f_code)
        used = [i for i, b in self.pending.items() if any(_uses(frame, n) for n, _ in b)]
        for number in used:
            branch = self.pending.pop(number)
            source, pipe = os.pipe()
            child = os.fork()
            if not child:
                sys.setprofile(None)
                self.pipe = pipe
                _set(branch)
                return
            os.close(pipe)
            with open(source, "rb") as stream:
                told = stream.read()
            if os.waitpid(child, 0)[1]:
                raise RuntimeError(f"branch {number} failed")
            self.results[number] = pickle.loads(told)


def _uses(frame: FrameType, names: Names) -> bool:
    used, module = frame.f_code.co_names, frame.f_globals.get("__name__")
    for of, name in names.places:
        if name not in used:
            continue
        if module == of:
            return True
        held = sys.modules.get(of)
        if any(value is held for value in frame.f_globals.values() if _is_module(value)):
            return True
    return False


def _is_module(value: Any) -> bool:
    return isinstance(value, ModuleType)


def _set(branch: Branch) -> None:
    for names, value in branch:
        for module, name in names.places:
            if module in sys.modules:
                setattr(sys.modules[module], name, value)
