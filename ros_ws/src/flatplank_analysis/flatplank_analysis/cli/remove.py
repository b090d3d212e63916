# SPDX-License-Identifier: Apache-2.0
"""Take an effect out of the model file and refit everything."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from flatplank_analysis.cli import change
from flatplank_analysis.contact_patch.session import Session


def main(argv: Sequence[str] | None = None) -> int:
    """`flatplank remove EFFECT [DIR] [--model FILE] [--json]`."""
    return change.run("remove", __doc__, argv, Session.remove, _words)


def _words(effect: str, numbers: dict[str, Any], path: Path) -> str:
    return (
        f"{effect} removed: error of Fx {numbers['rmse']:.1f} N, "
        f"floor {numbers['floor']:.1f} N; written to {path}"
    )
