# SPDX-License-Identifier: Apache-2.0
"""Many campaigns on one worker and on two.

Processes and a cluster: efficiency, and the memory of the client; campaigns that only wait, or
with --real campaigns of the blind kit that are made and diagnosed.
"""

from __future__ import annotations

import json
import resource
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from typing import Any

from flatplank_analysis.cli import common
from flatplank_analysis.parallel import Executor, Processes, open_executor
from flatplank_data.arguments import Parser, add_json
from flatplank_validation.blind.journal import solve
from flatplank_validation.blind.lists import full

EFFICIENCY, MEMORY = 0.9, 500.0
"""wanted from one worker to two; largest memory of the client [MiB]"""
EMPTY = 10_000
"""number of jobs that do nothing"""
RESULT = 10_000
"""size of the result of a stub campaign [bytes]"""
SEED = 57
"""of the real campaigns"""


Work = Callable[[Any], bytes]


def stub(seconds: float) -> bytes:
    """A campaign that takes its time and returns as much as a diagnosis does."""
    time.sleep(seconds)
    return bytes(RESULT)


def real(case: Any) -> bytes:
    """A campaign of the blind kit, made and diagnosed: its line of a journal."""
    return json.dumps(solve(case, SEED)).encode()


@contextmanager
def processes(workers: int) -> Iterator[Executor]:
    """Worker processes of this computer."""
    yield Processes(workers)


@contextmanager
def cluster(workers: int) -> Iterator[Executor]:
    """A cluster of one scheduler and its workers on this computer."""
    from distributed import LocalCluster

    with (
        LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as own,
        open_executor(scheduler=own.scheduler_address) as executor,
    ):
        yield executor


CREWS: dict[str, Callable[[int], AbstractContextManager[Executor]]] = {
    "processes": processes,
    "cluster": cluster,
}


def main(argv: Sequence[str] | None = None) -> int:
    """`flatplank bench-scale [CREW...] [--count N | --real N] [--json]`; exit code 1: a goal is
    missed."""
    parser = Parser(prog="flatplank bench-scale", description=__doc__)
    parser.add_argument("crews", nargs="*", help=f"some of {', '.join(CREWS)}; default: all")
    parser.add_argument("--count", type=int, default=3700, help="stub campaigns (default 3700)")
    parser.add_argument("--seconds", type=float, default=0.05, help="of each (default 0.05)")
    parser.add_argument("--real", type=int, metavar="N", help="instead: real campaigns, 20 s each")
    add_json(parser)
    o = parser.parse_args(argv)
    for name in o.crews:
        if name not in CREWS:
            parser.error(f"unknown crew '{name}'; known are {', '.join(CREWS)}")
    work: tuple[Work, Sequence[Any]] = (stub, [o.seconds] * o.count)
    if o.real:
        work = (real, full(SEED)[: o.real])
    found = {name: measure(CREWS[name], *work) for name in o.crews or CREWS}
    if o.json:
        common.print_json(found)
    else:
        for name, numbers in found.items():
            print(line_of(name, len(work[1]), numbers))
    good = all(n["efficiency"] >= EFFICIENCY and n["memory"] <= MEMORY for n in found.values())
    return int(not good)


def measure(
    crew: Callable[[int], AbstractContextManager[Executor]], work: Work, items: Sequence[Any]
) -> dict[str, float]:
    """Times [s] with one and two workers and of empty jobs; efficiency; memory [MiB]."""
    one, two = (timed(crew, workers, work, items) for workers in (1, 2))
    empty = timed(crew, 2, stub, [0.0] * EMPTY)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    return {
        "one": one, "two": two, "efficiency": one / (2.0 * two), "empty": empty, "memory": memory,
    }  # fmt: skip


def timed(
    crew: Callable[[int], AbstractContextManager[Executor]], workers: int, work: Work,
    items: Sequence[Any],
) -> float:  # fmt: skip
    """Time [s] of campaigns, once the workers have started."""
    with crew(workers) as executor:
        sum(map(len, executor.map(stub, [0.0] * workers)))
        begin = time.perf_counter()
        sum(map(len, executor.map(work, items)))
        return time.perf_counter() - begin


def line_of(name: str, count: int, n: dict[str, float]) -> str:
    """One row of the answer, each number with its goal."""
    return (
        f"{name}: {count} campaigns {n['one']:.1f} s on one worker, {n['two']:.1f} s on two, "
        f"efficiency {n['efficiency']:.3f} (>= {EFFICIENCY}); {EMPTY} empty jobs "
        f"{n['empty']:.1f} s; client {n['memory']:.0f} MiB (<= {MEMORY:.0f})"
    )
