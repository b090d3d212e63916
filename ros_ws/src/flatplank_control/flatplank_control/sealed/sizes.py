# SPDX-License-Identifier: Apache-2.0
"""Whether the size of what was named can be held against the size of what is hidden."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def comparable(
    match: Mapping[str, Any], hidden: Mapping[str, Any], diagnosis: Mapping[str, Any]
) -> bool:
    """False for metres against newtons.

    An effect that cannot be told from the hidden one may be named in its place, and counts as
    right; its size is then another quantity.

    Args:
        match: of `score`, of an effect that was named.
        hidden: of the answer.
        diagnosis: JSON of `diagnose`.
    """
    unit = next((e.get("unit") for e in diagnosis["effects"] if e["name"] == match["as"]), None)
    return unit is None or hidden.get("unit") in (None, unit)
