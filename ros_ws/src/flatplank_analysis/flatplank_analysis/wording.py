# SPDX-License-Identifier: Apache-2.0
"""How numbers are written for people."""

from __future__ import annotations


def quantity(value: float, unit: str, digits: int = 3) -> str:
    """A number with its unit; what has none (unit "1") stands alone."""
    return f"{value:.{digits}g}" + ("" if unit == "1" else f" {unit}")
