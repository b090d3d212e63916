# SPDX-License-Identifier: Apache-2.0
"""What a process with a cycle asks of the kernel: real-time scheduling and exact timers."""

from __future__ import annotations

import ctypes
import os

PR_SET_TIMERSLACK = 29


def _prctl(option: int, value: int) -> None:
    ctypes.CDLL(None, use_errno=True).prctl(option, ctypes.c_ulong(value), 0, 0, 0)


def prepare(fifo: bool, priority: int) -> str:
    """Exact timers and, when asked for and allowed, SCHED_FIFO; says what came of it."""
    _prctl(PR_SET_TIMERSLACK, 1)
    if not fifo:
        return "ordinary scheduling"
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except OSError:
        return (
            "ordinary scheduling (SCHED_FIFO not allowed: run as root, give CAP_SYS_NICE,"
            " or set rtprio in /etc/security/limits.conf)"
        )
    return f"SCHED_FIFO {priority}"
