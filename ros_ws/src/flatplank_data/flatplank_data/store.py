# SPDX-License-Identifier: Apache-2.0
"""Access to a campaign folder on a local disk or on any fsspec file system."""

from __future__ import annotations

import io
import os
import posixpath
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO, TypeAlias

from flatplank_data.errors import FlatplankError


@dataclass(frozen=True)
class LocalStore:
    """A local folder; names are relative to it and use '/'."""

    root: str

    def names(self, folder: str = "") -> list[str]:
        """Files and folders directly in the root, or in a folder of the root, sorted."""
        return sorted(os.listdir(self._path(folder)))

    def exists(self, name: str) -> bool:
        return os.path.exists(self._path(name))

    def is_dir(self, name: str) -> bool:
        return os.path.isdir(self._path(name))

    def open(self, name: str) -> BinaryIO:
        return open(self._path(name), "rb")

    def local(self, name: str) -> Path:
        """A local path with the content of `name` (a file or a folder)."""
        return Path(self._path(name))

    def size_and_time(self, name: str) -> tuple[int, int]:
        """Size [bytes] and modification time [ns] of a file."""
        stat = os.stat(self._path(name))
        return stat.st_size, stat.st_mtime_ns

    def _path(self, name: str) -> str:
        return os.path.join(self.root, name)


@dataclass(frozen=True)
class RemoteStore:
    """A folder on an fsspec file system (`memory://`, `s3://`, `sftp://`, ...)."""

    root: str
    _temp: list = field(default_factory=list, compare=False, repr=False)

    def _fs(self):
        try:
            import fsspec
        except ImportError as error:
            what = "a folder with a protocol needs the package fsspec"
            raise FlatplankError(what, self.root, "pip install fsspec") from error
        return fsspec.core.url_to_fs(self.root)

    def names(self, folder: str = "") -> list[str]:
        fs, path = self._fs()
        found = fs.ls(posixpath.join(path, folder).rstrip("/"), detail=False)
        return sorted(posixpath.basename(p.rstrip("/")) for p in found)

    def exists(self, name: str) -> bool:
        fs, path = self._fs()
        return bool(fs.exists(posixpath.join(path, name)))

    def is_dir(self, name: str) -> bool:
        fs, path = self._fs()
        return bool(fs.isdir(posixpath.join(path, name)))

    def open(self, name: str) -> BinaryIO:
        fs, path = self._fs()
        return io.BytesIO(fs.cat_file(posixpath.join(path, name)))

    def local(self, name: str) -> Path:
        fs, path = self._fs()
        if not self._temp:
            self._temp.append(tempfile.TemporaryDirectory(prefix="flatplank-"))
        target = Path(self._temp[0].name) / name
        if not target.exists():
            target.parent.mkdir(parents=True, exist_ok=True)
            fs.get(posixpath.join(path, name), str(target), recursive=self.is_dir(name))
        return target

    def size_and_time(self, name: str) -> tuple[int, int]:
        fs, path = self._fs()
        details = fs.info(posixpath.join(path, name))
        return int(details.get("size") or 0), 0


Store: TypeAlias = LocalStore | RemoteStore


def open_store(path: str | os.PathLike[str]) -> Store:
    """The store of a campaign folder."""
    text = os.fspath(path)
    if "://" in text:
        return RemoteStore(text.rstrip("/"))
    if not os.path.isdir(text):
        raise FlatplankError("no such folder", text, "give the folder that has campaign.yaml")
    return LocalStore(text)
