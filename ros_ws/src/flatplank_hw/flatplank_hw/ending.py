# SPDX-License-Identifier: Apache-2.0
"""A process ends in time even when the middleware does not let it.

Fast DDS 2.14 takes its participant down with a wait "for ever" whose end overflows. When another
node says goodbye in that moment, the wait turns in a circle with the lock that it waits for, and
the process never ends. It holds the interpreter meanwhile, so only the C library can end it.
Seldom it crashes there. The thread that crashes is held then until the timer ends the process.
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys

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
