# SPDX-License-Identifier: Apache-2.0
"""Tire property files that come with the package."""

from __future__ import annotations

from importlib import resources

from .tir import TirFile, parse_tir

SHIPPED = ("toyo_nanoenergy", "continental_ecocontact")


def shipped_tir(name: str = SHIPPED[0]) -> TirFile:
    """A parameter set that comes with the package (thesis Table I.1)."""
    file = resources.files("flatplank_analysis") / "tire_data" / f"{name}.tir"
    return parse_tir(file.read_text(encoding="utf-8"), f"{name}.tir")
