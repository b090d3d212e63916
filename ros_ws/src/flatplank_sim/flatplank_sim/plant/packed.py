# SPDX-License-Identifier: Apache-2.0
"""Text that keeps eyes off: base64 of zlib of JSON. It keeps no secrets."""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Mapping
from typing import Any


def pack(content: Mapping[str, Any]) -> str:
    """A mapping as one word."""
    return base64.b64encode(zlib.compress(json.dumps(content, sort_keys=True).encode())).decode()


def unpack(text: str) -> dict[str, Any]:
    """The mapping again; ValueError when the word is damaged."""
    try:
        return dict(json.loads(zlib.decompress(base64.b64decode(text))))
    except (TypeError, zlib.error) as error:
        raise ValueError(str(error)) from None
