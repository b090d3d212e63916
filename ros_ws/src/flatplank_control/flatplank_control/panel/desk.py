# SPDX-License-Identifier: Apache-2.0
"""The analyst's desk: campaigns of the data folder, and one that is open for discovery."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from flatplank_control.panel import validation as check
from flatplank_control.panel.analysis.client import Analysis
from flatplank_control.panel.next_plan import write_next

MODEL = "model.yaml"


class Desk:
    """Requests of the pages Runs and Discover, checked; ValueError is a refusal."""

    def __init__(self, data: Path, log: Path | None = None) -> None:
        self.data = data
        self.looking = Analysis(log)
        self.thinking = Analysis(log)
        self.open_folder = ""
        self._open_model = ""
        self.progress: tuple[str, float] = ("", 0.0)
        self.next_run: dict[str, Any] = {}
        self.tire = ""

    def close(self) -> None:
        self.looking.close()
        self.thinking.close()

    def _folder(self, folder: str) -> Path:
        path = check.inside(self.data, folder)
        if not path.is_dir():
            raise ValueError(f"{str(folder)[:80]!r}: no such folder below the data folder")
        return path

    # quick
    async def campaigns(self) -> list[dict[str, Any]]:
        return await self.looking.ask("campaigns", root=str(self.data))

    async def runs(self, folder: str) -> dict[str, Any]:
        found = await self.looking.ask("runs", folder=str(self._folder(folder)))
        self.tire = found["tire"]
        return found

    async def curves(
        self, folder: str, files: Sequence[str], channel: str, over: str
    ) -> dict[str, Any]:
        where = self._folder(folder)
        for file in files:
            check.inside(where, file, "file")
        return await self.looking.ask(
            "curves", folder=str(where), files=list(files), channel=channel, over=over
        )

    # the loop
    def _say(self, text: str, share: float) -> None:
        self.progress = (text, share)

    async def _think(self, job: str, **arguments: Any) -> Any:
        try:
            return await self.thinking.ask(job, self._say, **arguments)
        finally:
            self.progress = ("", 0.0)

    async def open(self, folder: str, model: str = "") -> dict[str, Any]:
        """Open a campaign; the model file is model.yaml of the campaign when `model` is empty."""
        where = self._folder(folder)
        path = check.inside(self.data, model, "model file") if model else where / MODEL
        if path.suffix != ".yaml":
            raise ValueError("a model file ends in .yaml")
        self.open_folder, self._open_model = folder, model
        return await self._think("open", folder=str(where), model=str(path))

    async def _reopened(self) -> None:
        """After a cancelled search the process is a new one and has nothing open."""
        if not self.open_folder:
            raise ValueError("open a campaign first")
        if not self.thinking.alive:
            await self.open(self.open_folder, self._open_model)

    async def compare(self) -> dict[str, Any]:
        await self._reopened()
        return await self._think("compare")

    async def diagnose(self) -> dict[str, Any]:
        await self._reopened()
        found = await self._think("diagnose")
        self.next_run = found.get("next_run") or {}
        return found

    async def add(self, effect: str) -> dict[str, Any]:
        await self._reopened()
        return await self._think("add", effect=check.note(effect)[:80])

    async def remove(self, effect: str) -> dict[str, Any]:
        await self._reopened()
        return await self._think("remove", effect=check.note(effect)[:80])

    async def report(self) -> Path:
        await self._reopened()
        target = check.folder_below(self.data, "reports/" + Path(self.open_folder).name)
        return Path((await self._think("report", folder=str(target)))["page"])

    def plan_next(self) -> Path:
        """The proposed run as a plan that the page Bench offers."""
        return write_next(self.next_run, self.tire, self.data)
