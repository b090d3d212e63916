# SPDX-License-Identifier: Apache-2.0
"""Reads and replaces whole files, so that no program reads a half-written one."""

from __future__ import annotations

import fcntl
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from flatplank_data.errors import UnwritableError


def read_text(path: str | Path) -> str:
    """The text of a UTF-8 file. Raises ValueError, in one line, when it cannot be read."""
    try:
        return Path(path).read_text(encoding="utf-8")
    except OSError as error:
        raise ValueError(f"{path}: cannot be read ({error.strerror})") from None
    except UnicodeDecodeError:
        raise ValueError(f"{path}: cannot be read (it is no text)") from None


@contextmanager
def only_writer(path: str | os.PathLike[str]) -> Iterator[None]:
    """Wait until no other program changes a file, and keep the others waiting: around reading,
    comparing and replacing it. The lock is a file beside it and ends with the program.

    Raises UnwritableError when the lock cannot be made.
    """
    target = Path(path)
    try:
        lock = target.with_name(f".{target.name}.lock").open("a")
    except OSError as error:
        what = f"cannot be written ({error.strerror})"
        raise UnwritableError(what, str(target), "choose another place") from error
    with lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


PART = ".part"
"""suffix of a file that is being written; a leftover one may be deleted"""


def write_atomic(path: str | os.PathLike[str], content: str | bytes, durable: bool = True) -> None:
    """Replace a file in one step, even when the program is killed or several write the file.

    durable: wait for the disk, so that also a power failure leaves the old file or the new one.
    Raises UnwritableError when the file cannot be written.
    """
    target = Path(path)
    temporary = None
    try:
        handle, temporary = tempfile.mkstemp(PART, f".{target.name}.", target.parent)
        with os.fdopen(handle, "wb") as stream:
            stream.write(content.encode() if isinstance(content, str) else content)
            stream.flush()
            if durable:
                os.fsync(stream.fileno())
        os.chmod(temporary, 0o644)
        os.replace(temporary, target)
    except BaseException as error:
        if temporary is not None:
            Path(temporary).unlink(missing_ok=True)
        if not isinstance(error, OSError):
            raise
        what = f"cannot be written ({error.strerror or error})"
        raise UnwritableError(what, str(target), "choose another place") from error
