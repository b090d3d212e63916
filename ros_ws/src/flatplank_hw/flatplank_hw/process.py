# SPDX-License-Identifier: Apache-2.0
"""A process of the bench and its system: it ends with the one that started it, ends in time, asks
for real-time scheduling, and hands its module path to child processes."""

from __future__ import annotations

import ctypes
import gc
import os
import signal
import sys
from pathlib import Path

END_WITH_PARENT = "FLATPLANK_END_WITH_PARENT"
"""environment: id of the process that the node belongs to"""

STARTED = "FLATPLANK_STARTED"
"""environment: file that the node makes as soon as it listens"""

_PR_SET_PDEATHSIG = 1


def end_with_parent() -> None:
    """Get SIGTERM when the parent named in the environment dies (Linux)."""
    parent = os.environ.get(END_WITH_PARENT)
    if parent is None:
        return
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != int(parent):
        raise SystemExit(f"the process {parent} that started this node is gone")


def tell_started() -> None:
    """Make the file that the environment names, if any."""
    if file := os.environ.get(STARTED):
        Path(file).touch()


SIGEV_THREAD = 2
CLOCK_MONOTONIC = 1
CRASHES = (signal.SIGABRT, signal.SIGBUS, signal.SIGSEGV)
LONGEST = min(CRASHES) - 1
"""a crash is answered by `sleep(number of the signal)`: the timer must come before [s]"""


class _Event(ctypes.Structure):
    """`struct sigevent` of Linux on 64 bits: `function(value)` in a thread of its own."""

    _fields_ = (
        ("value", ctypes.c_size_t),
        ("signal", ctypes.c_int),
        ("notify", ctypes.c_int),
        ("function", ctypes.c_void_p),
        ("attributes", ctypes.c_void_p),
        ("rest", ctypes.c_byte * 32),
    )


class _Times(ctypes.Structure):
    """`struct itimerspec`: how often again, and when first."""

    _fields_ = tuple(
        (f"{what}_{unit}", ctypes.c_long) for what in ("again", "first") for unit in ("s", "ns")
    )


def end_within(seconds: float, code: int) -> None:
    """End this process with the exit code when it has not ended by itself in so long [s].

    To be called when all work is done: files are closed, motors are off.

    Raises:
        ValueError: more than `LONGEST` seconds.
        OSError: the system gives no timer.
    """
    if not 0.0 < seconds <= LONGEST:
        raise ValueError(f"{seconds:g} s, must be more than 0 and at most {LONGEST}")
    sys.stdout.flush()
    sys.stderr.flush()
    library = ctypes.CDLL(None, use_errno=True)
    end = ctypes.cast(library._exit, ctypes.c_void_p)
    event = _Event(value=code, notify=SIGEV_THREAD, function=end.value)
    timer = ctypes.c_void_p()
    times = _Times(first_s=int(seconds), first_ns=int(seconds % 1.0 * 1e9))
    if library.timer_create(CLOCK_MONOTONIC, ctypes.byref(event), ctypes.byref(timer)) or (
        library.timer_settime(timer, 0, ctypes.byref(times), None)
    ):
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    library.signal.argtypes = (ctypes.c_int, ctypes.c_void_p)
    library.signal.restype = ctypes.c_void_p
    for number in CRASHES:
        library.signal(number, ctypes.cast(library.sleep, ctypes.c_void_p))


PR_SET_TIMERSLACK = 29
NOT_ALLOWED = (
    "ordinary scheduling (SCHED_FIFO not allowed: run as root, give CAP_SYS_NICE,"
    " or set rtprio in /etc/security/limits.conf)"
)


def _prctl(option: int, value: int) -> None:
    ctypes.CDLL(None, use_errno=True).prctl(option, ctypes.c_ulong(value), 0, 0, 0)


def _fifo(thread: int, priority: int) -> str:
    try:
        os.sched_setscheduler(thread, os.SCHED_FIFO, os.sched_param(priority))
    except OSError:
        return NOT_ALLOWED
    return f"SCHED_FIFO {priority}"


def prepare(fifo: bool, priority: int) -> str:
    """Exact timers and, when asked for and allowed, SCHED_FIFO for this thread; says what came of
    it."""
    _prctl(PR_SET_TIMERSLACK, 1)
    return _fifo(0, priority) if fifo else "ordinary scheduling"


def prepare_threads(priority: int) -> str:
    """For a program with threads, those of DDS among them: SCHED_FIFO for all where allowed (0:
    not asked for), and what there is now is looked at by no garbage collection any more."""
    gc.collect()
    gc.freeze()
    if not priority:
        return "ordinary scheduling"
    outcomes = [_fifo(int(thread), priority) for thread in os.listdir("/proc/self/task")]
    return outcomes[0]


def environment(*more: Path) -> dict[str, str]:
    """This process's environment, with this package, and more folders that packages lie in, in
    front of the child's module path.
    """
    folders = [*map(str, more), str(Path(__file__).parents[1])]
    before = os.environ.get("PYTHONPATH", "")
    path = ":".join([*folders, before] if before else folders)
    return {**os.environ, "PYTHONPATH": path}
