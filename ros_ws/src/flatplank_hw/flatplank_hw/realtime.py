# SPDX-License-Identifier: Apache-2.0
"""What a process with a cycle asks of the kernel: real-time scheduling and exact timers."""

from __future__ import annotations

import ctypes
import gc
import os

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
