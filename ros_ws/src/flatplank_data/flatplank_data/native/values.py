# SPDX-License-Identifier: Apache-2.0
"""Values as bytes and back: nested mappings of arrays, numbers and texts, without pickle."""

from __future__ import annotations

import io
import json
from typing import Any

import numpy as np

_TREE = "tree"


def to_bytes(value: Any) -> bytes:
    """`value` as an archive of arrays; what is neither array, number, text nor mapping is None."""
    arrays: list[np.ndarray] = []
    tree = json.dumps(_encoded(value, arrays)).encode()
    stream = io.BytesIO()
    named = {str(i): array for i, array in enumerate(arrays)}
    np.savez(stream, **{_TREE: np.frombuffer(tree, dtype=np.uint8)}, **named)
    return stream.getvalue()


def from_bytes(data: bytes) -> Any:
    """The value of `to_bytes`."""
    with np.load(io.BytesIO(data), allow_pickle=False) as archive:
        return _decoded(json.loads(archive[_TREE].tobytes()), archive)


def _encoded(value: Any, arrays: list[np.ndarray]) -> Any:
    if isinstance(value, dict):
        return {"map": {str(k): _encoded(v, arrays) for k, v in value.items()}}
    if isinstance(value, (list, tuple)) or getattr(value, "dtype", None) == np.dtype(object):
        return {"list": [_encoded(v, arrays) for v in value]}
    if isinstance(value, np.ndarray):
        arrays.append(value)
        return {"array": str(len(arrays) - 1)}
    plain = value.item() if isinstance(value, np.generic) else value
    return {"plain": plain if isinstance(plain, (bool, int, float, str)) else None}


def _decoded(node: Any, archive: Any) -> Any:
    ((kind, content),) = node.items()
    if kind == "map":
        return {k: _decoded(v, archive) for k, v in content.items()}
    if kind == "list":
        return [_decoded(v, archive) for v in content]
    return archive[content] if kind == "array" else content
