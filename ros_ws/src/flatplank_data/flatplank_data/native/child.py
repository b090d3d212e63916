# SPDX-License-Identifier: Apache-2.0
"""The process that parses: `python -m flatplank_data.native.child`, fed through its pipes.

A request is the name of a parser and a file; the answer its values or its error. Memory and
processor time are limited per file; the system ends the process when it needs more.
"""

from __future__ import annotations

import io
import os
import resource
import struct
import sys
import warnings
from collections.abc import Callable, Mapping
from typing import Any, BinaryIO

from flatplank_data.native.matlab73 import matlab73
from flatplank_data.native.values import to_bytes

HEAD = struct.Struct("<16sQ")
"""name of the parser, size of the file [bytes]"""
LENGTH = struct.Struct("<Q")
MEMORY, PER_BYTE = 1 << 30, 16
"""memory for a file: at least, and per byte of it [bytes]"""
SECONDS, RATE = 30, 1 << 20
"""processor time for a file: at least [s], and its least rate [bytes/s]"""


def _matlab(data: bytes) -> Any:
    from scipy.io import loadmat

    with warnings.catch_warnings():
        warnings.simplefilter("error")  # a variable that comes twice
        raw = loadmat(io.BytesIO(data), squeeze_me=True, simplify_cells=True)
    return {k: v for k, v in raw.items() if not k.startswith("__")}


PARSERS: Mapping[str, Callable[[bytes], Any]] = {"matlab": _matlab, "matlab 7.3": matlab73}


def _limit(size: int) -> None:
    """Limit memory and processor time for a file of `size` bytes."""
    pages = 0
    if os.path.exists("/proc/self/statm"):
        with open("/proc/self/statm", encoding="ascii") as stream:
            pages = int(stream.read().split()[0])
        memory = pages * resource.getpagesize() + MEMORY + PER_BYTE * size
        resource.setrlimit(resource.RLIMIT_AS, (memory, resource.RLIM_INFINITY))
    usage = resource.getrusage(resource.RUSAGE_SELF)
    seconds = int(usage.ru_utime + usage.ru_stime) + SECONDS + size // RATE
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, resource.RLIM_INFINITY))


def _answer(name: str, data: bytes) -> bytes:
    try:
        return to_bytes({"values": PARSERS[name](data)})
    except Exception as error:  # parsers raise many types of errors on a damaged file
        return to_bytes({"error": f"{type(error).__name__}: {error}"[:300]})


def serve(source: BinaryIO, target: BinaryIO) -> None:
    """Answer requests until the source ends."""
    while head := source.read(HEAD.size):
        name, size = HEAD.unpack(head)
        data = source.read(size)
        _limit(size)
        answer = _answer(name.rstrip(b"\0").decode(), data)
        target.write(LENGTH.pack(len(answer)) + answer)
        target.flush()


if __name__ == "__main__":
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a library prints does not get among the answers
    serve(sys.stdin.buffer, answers)
