# SPDX-License-Identifier: Apache-2.0
"""Text files as a whole: read, and replaced so that no half of one is ever seen."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from flatplank_data.errors import FlatplankError


def read_text(path: str | Path) -> str:
    """The text of a UTF-8 file; ValueError says in one line why it cannot be read."""
    try:
        return Path(path).read_text(encoding="utf-8")
    except OSError as error:
        raise ValueError(f"{path}: cannot be read ({error.strerror})") from None
    except UnicodeDecodeError:
        raise ValueError(f"{path}: cannot be read (it is no text)") from None


def replace_text(path: Path, content: str) -> None:
    """Write a file so that a kill leaves the old one or the new one, never half of it."""
    temporary = path.with_name(path.name + ".part")
    temporary.write_text(content, encoding="utf-8")
    temporary.replace(path)


def write_atomic(path: str | os.PathLike[str], text: str) -> None:
    """Replace a text file as `replace_text` does, also where several programs write it or the
    power fails; FlatplankError where it cannot be written."""
    target = Path(path)
    try:
        handle, temporary = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.")
    except OSError as error:
        raise FlatplankError(
            f"cannot be written ({error.strerror})", str(target), "choose another place"
        ) from error
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as stream:
            stream.write(text)
            stream.flush()
            os.fsync(stream.fileno())
        os.chmod(temporary, 0o644)
        os.replace(temporary, target)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise
