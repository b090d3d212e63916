# SPDX-License-Identifier: Apache-2.0
"""Process control: end with the parent process, end in time, request real-time scheduling, pass
the module path to child processes."""

from __future__ import annotations

import ctypes
import gc
import os
import signal
import sys
from pathlib import Path

END_WITH_PARENT = "FLATPLANK_END_WITH_PARENT"
"""environment variable: id of the process with which the node is to end"""

STARTED = "FLATPLANK_STARTED"
"""environment variable: file that the node makes once it is ready"""

_PR_SET_PDEATHSIG = 1


def end_with_parent() -> None:
    """Request SIGTERM for the case that the parent named in the environment dies (Linux)."""
    parent = os.environ.get(END_WITH_PARENT)
    if parent is None:
        return
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != int(parent):
        raise SystemExit(f"the process {parent} that started this node is gone")


def report_started() -> None:
    """Make the file that reports the start, if the environment names one."""
    if file := os.environ.get(STARTED):
        Path(file).touch()


SIGEV_THREAD = 2
CLOCK_MONOTONIC = 1
CRASHES = (signal.SIGABRT, signal.SIGBUS, signal.SIGSEGV)
LONGEST = min(CRASHES) - 1
"""longest time of the timer [s]: a crash during exit calls `sleep(signal number)`, which must last
longer"""


class _Event(ctypes.Structure):
    """`struct sigevent` of 64-bit Linux: calls `function(value)` in a new thread."""

    _fields_ = (
        ("value", ctypes.c_size_t),
        ("signal", ctypes.c_int),
        ("notify", ctypes.c_int),
        ("function", ctypes.c_void_p),
        ("attributes", ctypes.c_void_p),
        ("rest", ctypes.c_byte * 32),
    )


class _Times(ctypes.Structure):
    """`struct itimerspec`: interval and first expiration."""

    _fields_ = tuple(
        (f"{what}_{unit}", ctypes.c_long) for what in ("again", "first") for unit in ("s", "ns")
    )


def end_within(seconds: float, code: int) -> None:
    """End this process with exit code `code` if it has not ended by itself within `seconds` [s].

    Call this when all work is done: files are closed, motors are off.

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


def prepare_thread(fifo: bool, priority: int) -> str:
    """Set exact timers and, if requested and allowed, SCHED_FIFO for this thread; returns the
    result."""
    _prctl(PR_SET_TIMERSLACK, 1)
    return _fifo(0, priority) if fifo else "ordinary scheduling"


def prepare_threads(priority: int) -> str:
    """Prepare a program with threads, such as those of DDS: SCHED_FIFO for all where allowed (0:
    not requested); exempts existing objects from garbage collection."""
    gc.collect()
    gc.freeze()
    if not priority:
        return "ordinary scheduling"
    outcomes = [_fifo(int(thread), priority) for thread in os.listdir("/proc/self/task")]
    return outcomes[0]


def child_environment(*more: Path) -> dict[str, str]:
    """Environment for a child process: that of this process, with the folders of this and further
    packages first in the module path.
    """
    folders = [*map(str, more), str(Path(__file__).parents[1])]
    before = os.environ.get("PYTHONPATH", "")
    path = ":".join([*folders, before] if before else folders)
    return {**os.environ, "PYTHONPATH": path}
