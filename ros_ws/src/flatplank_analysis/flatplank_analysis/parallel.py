# SPDX-License-Identifier: Apache-2.0
"""Parallel execution of independent jobs: in this process, in processes, or on a Dask cluster."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractContextManager, contextmanager, nullcontext
from threading import Thread
from typing import Any, Protocol, TypeVar

from flatplank_data.errors import FlatplankError

Item = TypeVar("Item")
Result = TypeVar("Result")
RETRIES = 3
"""number of times that work is repeated after a worker has died"""


class Executor(Protocol):
    """Maps a module-level function over items; results keep the order of the items."""

    def map(
        self, function: Callable[[Item], Result], items: Iterable[Item]
    ) -> Iterator[Result]: ...


class Serial:
    """Execution in this process."""

    def map(self, function: Callable[[Item], Result], items: Iterable[Item]) -> Iterator[Result]:
        return map(function, items)


def worker_pool(
    jobs: int, context: multiprocessing.context.BaseContext | None = None
) -> ProcessPoolExecutor:
    """Worker processes, spawned by default, that end when this process ends in any way."""
    chosen = context or multiprocessing.get_context("spawn")
    return ProcessPoolExecutor(jobs, mp_context=chosen, initializer=end_with_parent)


def end_with_parent() -> None:
    """End this worker with its parent: it keeps its own pipe open, and so would wait for ever."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        Thread(target=_wait_for, args=(parent,), daemon=True).start()


def _wait_for(parent: multiprocessing.process.BaseProcess) -> None:
    parent.join()
    os._exit(1)


class Processes:
    """Execution in `jobs` processes; what a process that died had not finished is repeated."""

    def __init__(self, jobs: int) -> None:
        self.jobs = jobs

    def map(self, function: Callable[[Item], Result], items: Iterable[Item]) -> Iterator[Result]:
        waiting = list(items)
        losses = 0
        while waiting:
            context = _context(function)
            with worker_pool(min(self.jobs, len(waiting)), context) as pool:
                try:
                    futures = [pool.submit(function, item) for item in waiting]
                    for future in futures:
                        result = future.result()
                        waiting.pop(0)
                        yield result
                except BrokenProcessPool as error:
                    losses += 1
                    if losses > RETRIES:
                        raise FlatplankError(
                            f"worker processes died {losses} times",
                            f"{self.jobs} jobs",
                            "use fewer --jobs (out of memory?)",
                        ) from error


def _context(function: Callable) -> multiprocessing.context.BaseContext:
    """Start method of workers: they share one import of their modules, where possible."""
    if "forkserver" not in multiprocessing.get_all_start_methods():
        return multiprocessing.get_context("spawn")
    context = multiprocessing.get_context("forkserver")
    if function.__module__ != "__main__":
        context.set_forkserver_preload([function.__module__])
    return context


class Dask:
    """Execution on a cluster with a scheduler address; its own retries cover lost workers."""

    def __init__(self, client: Any) -> None:
        self.client = client

    def map(self, function: Callable[[Item], Result], items: Iterable[Item]) -> Iterator[Result]:
        futures = self.client.map(function, list(items), retries=RETRIES, pure=False)
        return (future.result() for future in futures)


@contextmanager
def _dask(address: str) -> Iterator[Executor]:
    try:
        from distributed import Client
    except ImportError as error:
        what = "a scheduler needs the package distributed"
        raise FlatplankError(what, address, "pip install distributed") from error
    try:
        client = Client(address, timeout="20s", set_as_default=False)
    except OSError as error:
        what = f"no scheduler ({error})"
        raise FlatplankError(what, address, "start one, or leave '--scheduler' out") from error
    with client:
        yield Dask(client)


def available_cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def open_executor(
    jobs: int | None = None, scheduler: str | None = None
) -> AbstractContextManager[Executor]:
    """The executor for `--jobs N` (default: every core) or `--scheduler ADDRESS`."""
    if scheduler:
        return _dask(scheduler)
    jobs = jobs if jobs is not None else available_cores()
    if jobs < 1:
        raise FlatplankError(f"{jobs} jobs", "--jobs", "use 1 or more")
    return nullcontext(Serial() if jobs == 1 else Processes(jobs))
