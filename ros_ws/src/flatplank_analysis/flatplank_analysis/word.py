# SPDX-License-Identifier: Apache-2.0
"""A word of the glossary."""

from __future__ import annotations

from typing import NamedTuple


class Word(NamedTuple):
    """A word of an output or a parameter of the base."""

    title: str
    sentence: str
    unit: str = ""
    symbol: str = ""
