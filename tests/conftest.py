# SPDX-License-Identifier: Apache-2.0
"""What holds for every test: a quiet environment, long ones only on demand, and a run that says
what it has not run.
"""

from __future__ import annotations

import faulthandler
import importlib.util
import os
import resource
import signal
import tempfile
from collections import Counter
from collections.abc import Iterator
from typing import Any

import pytest

from flatplank_control.bench.fast_dds import loopback_environment

# One thread per process: two cores are shared by the nodes of a graph, and numbers repeat.
os.environ |= loopback_environment() | {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MPLBACKEND": "Agg",
    # the list of what the user allows to run stays as it is
    "XDG_CONFIG_HOME": tempfile.mkdtemp(prefix="flatplank-tests-"),
}

# Started in the background, the suite and all its children would be deaf to Ctrl-C.
signal.signal(signal.SIGINT, signal.default_int_handler)

CI = os.environ.get("CI", "").lower() not in ("", "0", "false")
"""here the environment is made for the tests: what cannot run is a failure"""
GRACE_S = float(os.environ.get("FLATPLANK_TEST_GRACE", "60"))
"""a test that hears no signal, for it hangs in compiled code, ends the run so long after its
time-out
"""

ROS_TOOLS = importlib.util.find_spec("ros2cli") is not None
"""the real command line of ROS is there"""
LONG_S = 20.0
"""processor time of a test [s] from which it is to be marked `long`, or made cheaper"""
TIMES = pytest.StashKey[dict[str, float]]()
NOT_RUN = pytest.StashKey[Counter[str]]()
LEFT = pytest.StashKey[set[str]]()
STDERR = pytest.StashKey[int]()


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--long", action="store_true", help="also the tests that take minutes")


def pytest_configure(config: pytest.Config) -> None:
    config.stash[NOT_RUN] = Counter()
    config.stash[LEFT] = set()
    config.stash[TIMES] = {}
    config.stash[STDERR] = os.dup(2)  # the capture of a test begins later


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    left_out = [item for item in items if _left_out(item)]
    if left_out:
        config.hook.pytest_deselected(items=left_out)
        items[:] = [item for item in items if not _left_out(item)]


def _left_out(item: pytest.Item) -> str:
    """Why a test is not asked here; empty when it is."""
    if item.get_closest_marker("long") and not item.config.getoption("--long", False):
        return "takes minutes; runs with --long"
    if item.get_closest_marker("installed_ros") and not ROS_TOOLS:
        return "needs the ros2 command of an installed Jazzy, which no package of the set-up has"
    return ""


def pytest_deselected(items: list[pytest.Item]) -> None:
    for item in items:
        why = _left_out(item) or "not chosen by -k, -m or --deselect"
        item.config.stash[NOT_RUN][why] += 1


def pytest_collection_finish(session: pytest.Session) -> None:
    session.config.stash[LEFT] = {item.nodeid for item in session.items}


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector: pytest.Collector) -> Iterator[None]:
    report = yield
    _judge(report, collector.config)
    return report


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Iterator[None]:
    report = yield
    item.config.stash[LEFT].discard(item.nodeid)
    _judge(report, item.config)
    return report


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """Keep the processor time of a test and its children: other work does not change it."""
    before = _processor_time()
    try:
        return (yield)
    finally:
        item.config.stash[TIMES][item.nodeid] = _processor_time() - before


def _processor_time() -> float:
    used = map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(usage.ru_utime + usage.ru_stime for usage in used)


def _judge(report: Any, config: pytest.Config) -> None:
    """Count a skip, or call it a failure."""
    if not report.skipped:
        return
    where = report.longrepr
    reason = where[2] if isinstance(where, tuple) else getattr(report, "wasxfail", str(where))
    reason = reason.removeprefix("Skipped: ")
    if CI:
        report.outcome = "failed"
        report.longrepr = f"not run, and with CI=true everything must run: {reason}"
    else:
        config.stash[NOT_RUN][reason] += 1


def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    """The last lines before the closing one."""
    times = config.stash[TIMES]
    cache = config.rootpath / ".cache"
    cache.mkdir(exist_ok=True)
    with (cache / "test-times.tsv").open("a") as file:  # parts of a run write to one
        file.writelines(f"{t:.2f}\t{name}\n" for name, t in times.items())
    slow = [name for name, t in times.items() if t > LONG_S and not config.getoption("--long")]
    if slow:
        terminalreporter.section(
            f"more than {LONG_S:.0f} s of processor time, with the children that ended in them"
        )
    for name in sorted(slow, key=times.__getitem__, reverse=True):
        terminalreporter.line(f"{times[name]:6.1f} s  {name}")
    terminalreporter.line(f"processor time of all tests: {sum(times.values()):.0f} s")
    left = config.stash[LEFT]
    if left and not config.getoption("collectonly"):
        config.stash[NOT_RUN]["the run ended before them"] += len(left)
    counts = config.stash[NOT_RUN]
    terminalreporter.section("not run")
    for reason, count in counts.most_common():
        terminalreporter.line(f"{count} {'test' if count == 1 else 'tests'}: {reason}")
    if not counts:
        terminalreporter.line("nothing: all that was asked for has run")


@pytest.hookimpl(wrapper=True)
def pytest_timeout_set_timer(item: pytest.Item, settings: Any) -> Iterator[None]:
    """For tests that hear no signal; not in a debugger."""
    if not item.config.getoption("usepdb"):
        stderr = item.config.stash[STDERR]
        faulthandler.dump_traceback_later(settings.timeout + GRACE_S, exit=True, file=stderr)
    return (yield)


def pytest_runtest_logfinish() -> None:
    faulthandler.cancel_dump_traceback_later()


def pytest_enter_pdb() -> None:
    faulthandler.cancel_dump_traceback_later()
