# SPDX-License-Identifier: Apache-2.0
"""What a failure of a verb is to its user: one line and an exit code, never a traceback."""

from __future__ import annotations

import errno
import os
import tempfile
import traceback

from flatplank_data.errors import FlatplankError

AT_FAULT = 1
"""The input, the computer or the bench is at fault; the line says how to mend it."""

UNEXPECTED = 70
"""The program is at fault (EX_SOFTWARE of sysexits.h); the line names the file of the trace."""

REMEDIES = {
    errno.ENOSPC: "free some space, or name a folder on another disk",
    errno.EDQUOT: "free some of your quota, or name a folder on another disk",
    errno.EFBIG: "raise the limit of file sizes (ulimit -f)",
    errno.EROFS: "name a folder that can be written",
    errno.EACCES: "name a folder that is yours, or get the permission",
    errno.EPERM: "get the permission",
    errno.EADDRINUSE: "end the program that has it, or name another port",
    errno.EMFILE: "raise the limit of open files (ulimit -n)",
    errno.ENOENT: "",
    errno.ENOTDIR: "",
    errno.EISDIR: "",
    errno.EEXIST: "",
}
"""Errors of the system that are the user's to mend, and how."""


def told(verb: str, error: BaseException) -> tuple[str, int]:
    """The line for the user and the exit code."""
    known = _known(error)
    if known is not None:
        return f"{verb}: {_one_line(known)}", AT_FAULT
    what = f"unexpected {type(error).__name__}: {_one_line(str(error)) or 'no message'}"
    file = _keep_trace(error)
    where = f"please report it with {file}" if file else "its trace could not be written anywhere"
    return f"{verb}: {what}; {where}", UNEXPECTED


def _known(error: BaseException) -> str | None:
    """Words for a failure that is foreseen."""
    if isinstance(error, FlatplankError | ValueError) or _is_ours(error):
        return str(error)
    if isinstance(error, OSError) and error.errno in REMEDIES:
        place = f"{error.filename}: " if error.filename else ""
        remedy = REMEDIES[error.errno]
        return f"{place}{error.strerror}" + (f"; {remedy}" if remedy else "")
    if isinstance(error, FileNotFoundError):  # raised by us, with a sentence
        return str(error)
    if isinstance(error, ImportError):
        return f"{error}; ./flatplank doctor says what is missing"
    if isinstance(error, MemoryError):
        return "not enough memory; --jobs 1 needs less where it is an option"
    if any(kind.__name__ == "BrokenExecutor" for kind in type(error).__mro__):
        return "a process of the calculation was killed, often for want of memory; try --jobs 1"
    return None


def _is_ours(error: BaseException) -> bool:
    """Defined by one of our packages, so written for the user."""
    return type(error).__module__.startswith("flatplank_")


def _keep_trace(error: BaseException) -> str:
    """Path of a file with the whole trace; empty when nothing can be written."""
    text = "".join(traceback.format_exception(error))
    try:
        handle, path = tempfile.mkstemp(prefix="flatplank-trace-", suffix=".txt")
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
    except OSError:
        return ""
    return path


def _one_line(text: str) -> str:
    return " ".join(text.split())
