# SPDX-License-Identifier: Apache-2.0
"""The log of an investigation beside its data: one line per event, on the disk before the bench
moves on."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flatplank_control.runner.campaign.journal import cut_torn_line, read_lines, write_line
from flatplank_data.errors import FlatplankError

NAME = "investigation.jsonl"
FORMAT = "flatplank-investigation/1"


class DiskLog:
    """Events of `flatplank_analysis.investigation.loop`; begins or goes on."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / NAME
        lines = read_lines(self.path)
        if lines and lines[0].get("format") != FORMAT:
            raise FlatplankError(
                f"is not of format {FORMAT}", str(self.path), "move it away, or choose another"
            )
        folder.mkdir(parents=True, exist_ok=True)
        cut_torn_line(self.path)
        self.events: list[dict[str, Any]] = lines

    def write(self, event: Mapping[str, Any]) -> None:
        """Keep one more."""
        line = dict(event) if self.events else {"format": FORMAT, **event}
        write_line(self.path, line)
        self.events.append(line)
