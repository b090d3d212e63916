# SPDX-License-Identifier: Apache-2.0
"""Parquet cache of tables read from bags, in a folder beside them, which may be deleted.

Its key contains size and time of the files of a bag.
"""

from __future__ import annotations

import contextlib
import glob
import hashlib
import json
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from flatplank_data.errors import FlatplankError
from flatplank_data.parquet_files import KEPT, keep, whole
from flatplank_data.readers.base import Loaded, Request
from flatplank_data.store import LocalStore

_VERSION = 3
_KEY = 16
"""length of a key"""
_FACTS, _REMARKS = b"flatplank.facts", b"flatplank.remarks"


def cache_key(request: Request) -> str:
    """Cache key; it changes with the bag, the mapping and the cache format."""
    store = request.store
    names = [request.name]
    if store.is_dir(request.name):
        folder = store.local(request.name)
        names = sorted(f"{request.name}/{p.name}" for p in folder.iterdir() if p.is_file())
    parts = [(name, *store.size_and_time(name)) for name in names]
    text = json.dumps([_VERSION, parts, request.mapping], sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:_KEY]


def load_cached(request: Request, key: str) -> Loaded | None:
    """The cached table, or None."""
    path = _path(request, key)
    if path is None or not path.exists():
        return None
    try:
        with whole(path.name):
            file = pq.ParquetFile(path, page_checksum_verification=True)
            names = [n for n in file.schema_arrow.names if request.wants(n)]
            table = file.read(columns=names, use_threads=False)
            metadata = file.schema_arrow.metadata or {}
            facts, remarks = json.loads(metadata[_FACTS]), json.loads(metadata[_REMARKS])
    except FlatplankError:
        return None
    return Loaded({n: table.column(n).to_numpy() for n in names}, facts, remarks)


def save_to_cache(request: Request, key: str, loaded: Loaded) -> None:
    """Cache a table; a read-only folder is no error."""
    path = _path(request, key)
    if path is None:
        return
    metadata = {
        _FACTS: json.dumps(dict(loaded.facts), default=str).encode(),
        _REMARKS: json.dumps(list(loaded.remarks)).encode(),
    }
    table = pa.table(dict(loaded.columns)).replace_schema_metadata(metadata)
    for old in path.parent.glob(f"{glob.escape(request.name)}-{'?' * _KEY}.parquet"):
        with contextlib.suppress(OSError):
            old.unlink()
    keep(table, path)


def _path(request: Request, key: str) -> Path | None:
    if not isinstance(request.store, LocalStore):
        return None
    return Path(request.store.root) / KEPT / f"{request.name}-{key}.parquet"
