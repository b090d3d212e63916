# SPDX-License-Identifier: Apache-2.0
"""One thing of several by its name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

from flatplank_analysis.errors import FlatplankError

Thing = TypeVar("Thing")


def chosen(known: Mapping[str, Thing], name: str) -> Thing:
    """`known[name]`, or one line with what there is."""
    if name not in known:
        raise FlatplankError(f"no figure '{name}'", "plot", f"known: {', '.join(known)}")
    return known[name]
