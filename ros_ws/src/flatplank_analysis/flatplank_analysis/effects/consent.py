# SPDX-License-Identifier: Apache-2.0
"""Consent to run the Python of an effect file: each user's own, remembered by the content.

A campaign of somebody else may name effect files. They run only after the user has allowed their
exact content; an edited file must be allowed again. Proposals are data and need no consent.
"""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Iterable
from pathlib import Path

from flatplank_data.errors import FlatplankError

WORDS = "is Python that you have not allowed to run"
_HERE: set[str] = set()
"""consent given in this process, also where the user's list cannot be written"""


class ConsentError(FlatplankError):
    """An effect file that may not run yet, with the content that would have run, as text, too."""

    def __init__(self, path: Path, content: bytes) -> None:
        self.path, self.content, self.text = path, content, text_of(path, content)
        super().__init__(WORDS, str(path), f"read it, then add: --trust {path}")


def list_of_user() -> Path:
    """The user's list: a line `sha256 path` for each content that may run."""
    config = os.environ.get("XDG_CONFIG_HOME") or Path.home() / ".config"
    return Path(config) / "flatplank" / "trusted-effects"


def digest(content: bytes) -> str:
    """What consent is remembered by."""
    return hashlib.sha256(content).hexdigest()


def is_given(content: bytes) -> bool:
    """Whether the user has allowed to run a file of this content."""
    try:
        lines = list_of_user().read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        lines = []
    return digest(content) in {*_HERE, *(line.partition(" ")[0] for line in lines)}


def give(files: Iterable[str | os.PathLike[str]]) -> None:
    """Allow to run these files as they are now; FlatplankError for a file that cannot be read."""
    for file in files:
        allow(Path(file), read(Path(file)))


def allow(path: Path, content: bytes) -> None:
    """Allow to run a file of this content; a list that cannot be written is a warning."""
    if is_given(content):
        return
    _HERE.add(digest(content))
    line = f"{digest(content)} {' '.join(str(path.resolve()).split())}\n"
    try:
        list_of_user().parent.mkdir(parents=True, exist_ok=True)
        with list_of_user().open("a", encoding="utf-8", errors="replace") as stream:
            stream.write(line)
    except OSError as error:
        what = f"{list_of_user()}: cannot be written ({error.strerror})"
        print(f"warning: {what}; {path} is allowed this time only", file=sys.stderr)


def read(path: Path) -> bytes:
    """Content of an effect file; FlatplankError when there is none."""
    if not path.is_file():
        raise FlatplankError("no such file", str(path), "give the path of an effect file")
    try:
        return path.read_bytes()
    except OSError as error:
        what = f"cannot be read ({error.strerror})"
        raise FlatplankError(what, str(path), "give the path of an effect file") from error


def text_of(path: Path, content: bytes) -> str:
    """The text that runs: UTF-8, whatever encoding the file names for itself."""
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise FlatplankError("is not UTF-8", str(path), "save it as UTF-8") from None


def shown(text: str) -> str:
    """The text for the eye: a character that would hide or reorder others is written as its
    number."""
    lines = text.replace("\r\n", "\n")
    return "".join(c if c in "\n\t" or c.isprintable() else ascii(c)[1:-1] for c in lines)
