# SPDX-License-Identifier: Apache-2.0
"""Parallel execution of independent jobs: in this process, in processes, or on a Dask cluster."""

from __future__ import annotations

import logging
import multiprocessing
import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import CancelledError, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractContextManager, contextmanager, nullcontext
from functools import partial
from threading import Thread
from typing import Any, Protocol, TypeVar

from flatplank_analysis.chunks import in_order
from flatplank_data.errors import FlatplankError

Item = TypeVar("Item")
Result = TypeVar("Result")


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
    """Execution in `jobs` processes."""

    def __init__(self, jobs: int) -> None:
        self.jobs = jobs

    def map(self, function: Callable[[Item], Result], items: Iterable[Item]) -> Iterator[Result]:
        todo = list(items)
        if not todo:
            return
        crew = _Pool(min(self.jobs, len(todo)), _context(function))
        try:
            yield from in_order(crew, function, todo)
        finally:
            crew.pool.shutdown(cancel_futures=True)


class _Pool:
    """Processes of this computer; when one dies, all are started anew."""

    lost: tuple[type[BaseException], ...] = (BrokenProcessPool,)

    def __init__(self, jobs: int, context: multiprocessing.context.BaseContext) -> None:
        self.jobs, self.context = jobs, context
        self.pool = worker_pool(jobs, context)

    def workers(self) -> int:
        return self.jobs

    def submit(self, work: Callable[..., Any], *arguments: Any) -> Future:
        try:
            return self.pool.submit(work, *arguments)
        except BrokenProcessPool as error:  # is told where the result is awaited
            broken: Future = Future()
            broken.set_exception(error)
            return broken

    def renew(self) -> None:
        self.pool.shutdown(cancel_futures=True)
        self.pool = worker_pool(self.jobs, self.context)


def _context(function: Callable) -> multiprocessing.context.BaseContext:
    """Start method of workers: they share one import of their modules, where possible."""
    if "forkserver" not in multiprocessing.get_all_start_methods():
        return multiprocessing.get_context("spawn")
    context = multiprocessing.get_context("forkserver")
    whole = function.func if isinstance(function, partial) else function
    if whole.__module__ != "__main__":
        context.set_forkserver_preload([whole.__module__])
    return context


class Dask:
    """Execution on a cluster; its scheduler repeats what a lost worker had not finished."""

    def __init__(self, client: Any) -> None:
        from distributed import KilledWorker

        self.client = client
        self.lost: tuple[type[BaseException], ...] = (KilledWorker,)

    def map(self, function: Callable[[Item], Result], items: Iterable[Item]) -> Iterator[Result]:
        return in_order(self, function, list(items))

    def workers(self) -> int:
        return sum(self.client.nthreads().values())

    def submit(self, work: Callable[..., Any], *arguments: Any) -> Any:
        return self.client.submit(work, *arguments, pure=False)

    def renew(self) -> None:
        """The cluster's own supervision starts workers."""


@contextmanager
def _dask(address: str) -> Iterator[Executor]:
    try:
        from distributed import Client
    except ImportError as error:
        what = "a scheduler needs the package distributed"
        raise FlatplankError(what, address, "pip install distributed") from error
    where = {"scheduler_file": address} if address.endswith(".json") else {"address": address}
    try:
        client = Client(**where, timeout="20s", set_as_default=False)
    except (OSError, ValueError) as error:
        what = f"no scheduler ({error})"
        raise FlatplankError(what, address, "start one, or leave '--scheduler' out") from error
    # its own report of a lost connection is a traceback
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)
    with client:
        try:
            yield Dask(client)
        except CancelledError as error:
            raise FlatplankError("the scheduler is gone", address, "start it again") from error


def available_cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def open_executor(
    jobs: int | None = None, scheduler: str | None = None
) -> AbstractContextManager[Executor]:
    """The executor for `--jobs N` (default: every core), or for `--scheduler ADDRESS`: an address
    or a scheduler file (.json)."""
    if scheduler:
        return _dask(scheduler)
    jobs = jobs if jobs is not None else available_cores()
    if jobs < 1:
        raise FlatplankError(f"{jobs} jobs", "--jobs", "use 1 or more")
    return nullcontext(Serial() if jobs == 1 else Processes(jobs))
