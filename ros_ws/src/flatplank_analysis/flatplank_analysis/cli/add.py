# SPDX-License-Identifier: Apache-2.0
"""Put an effect into the model file and refit everything jointly."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from flatplank_analysis.cli import change
from flatplank_analysis.contact_patch.session import Session
from flatplank_data.wording import sized


def main(argv: Sequence[str] | None = None) -> int:
    """`flatplank add EFFECT [DIR] [--model FILE] [--json]`."""
    return change.run("add", __doc__, argv, Session.add, _words)


def _words(effect: str, numbers: dict[str, Any], path: Path) -> str:
    lines = [
        f"{effect}: {sized(numbers['size'], numbers['interval'], numbers['unit'])}",
        f"error of Fx {numbers['rmse_before']:.1f} -> {numbers['rmse']:.1f} N, "
        f"held out {numbers['held_out']:.1f} N, floor {numbers['floor']:.1f} N; written to {path}",
    ]
    return "\n".join([*lines, *(f"doubt: {doubt}" for doubt in numbers["doubts"])])
