# SPDX-License-Identifier: Apache-2.0
"""Analysis for the pages: campaigns of the data folder, and the open campaign of each page."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Any

from flatplank_data.progress import Progress
from flatplank_panel import validation as check
from flatplank_panel.analysis.client import Analysis, ConsentNeeded
from flatplank_panel.next_plan import write_next

MODEL = "model.yaml"
FITS = "parasitic"
"""folder of the parasitic fits below the data folder"""
CONTROL_CHARTS = "reports/reference_tire"
"""folder of the page of the control charts below the data folder"""


Key = tuple[str, Path]
"""campaign and model file"""


@dataclass(eq=False)
class Search:
    """A search belongs to its campaign: it goes on without the page that began it, and every page
    of the campaign shows it."""

    task: asyncio.Task[Any]
    pages: set[PageAnalysis]
    progress: tuple[str, float] = ("", 0.0)

    @property
    def alive(self) -> bool:
        """False after it was cancelled or has failed."""
        ended = self.task.done()
        return not ended or not (self.task.cancelled() or self.task.exception())


class AnalysisService:
    """Checked analysis requests of all pages; a ValueError is a refusal."""

    def __init__(self, data: Path, log: Path | None = None) -> None:
        self.data = data
        self.browse_jobs = Analysis(log)
        self.cataloguing = Analysis(log)
        self.fit_jobs = Analysis(log)
        self.investigating = Analysis(log)
        self.searches: dict[Key, Search] = {}
        """running and finished searches of the present models"""

    def close(self) -> None:
        self.browse_jobs.close()
        self.cataloguing.close()
        self.fit_jobs.close()
        self.investigating.close()

    def folder(self, folder: str) -> Path:
        """An existing folder below the data folder."""
        path = check.inside(self.data, folder)
        if not path.is_dir():
            raise ValueError(f"{str(folder)[:80]!r}: no such folder below the data folder")
        return path

    async def campaigns(self) -> list[dict[str, Any]]:
        return await self.browse_jobs.ask("campaigns", root=str(self.data))

    async def runs(self, folder: str, tell: Progress | None = None) -> dict[str, Any]:
        return await self.browse_jobs.ask("runs", tell, folder=str(self.folder(folder)))

    async def curves(
        self,
        folder: str,
        files: Sequence[str],
        channel: str,
        over: str,
        tell: Progress | None = None,
        beside: str = "",
    ) -> dict[str, Any]:
        """Curves of some runs; `beside`: another campaign to be drawn over them."""
        where = self.folder(folder)
        for file in files:
            check.inside(where, file, "file")
        return await self.browse_jobs.ask(
            "curves", tell, folder=str(where), files=list(files), channel=channel, over=over,
            beside=str(self.folder(beside)) if beside else "",
        )  # fmt: skip

    async def catalogue(
        self, where: str, tell: Progress | None = None, **wish: Any
    ) -> dict[str, Any]:
        """Some of the runs below the data folder that fulfil the conditions; `wish`: order, first
        and count, as of the job."""
        return await self.cataloguing.ask(
            "catalogue", tell, root=str(self.data), where=check.note(where), **wish
        )

    async def reference_chart(self, where: str, tell: Progress | None = None) -> dict[str, Any]:
        """Control charts of the tire of the runs that fulfil the conditions; their page is below
        the data folder."""
        target = check.folder_below(self.data, CONTROL_CHARTS)
        return await self.fit_jobs.ask(
            "reference_chart", tell, root=str(self.data), where=check.note(where),
            target=str(target),
        )  # fmt: skip

    async def unloaded_turns(self) -> list[str]:
        """Bags from which the parasitic signal can be identified."""
        return await self.browse_jobs.ask("turns", root=str(self.data))

    async def identify(self, bag: str, mounting: str) -> tuple[str, dict[str, list[float]]]:
        """Identify the fit of a mounting from an unloaded run; returns its file below the data
        folder, and the once-per-turn forces before and after it [N]."""
        check.inside(self.data, bag, "run")
        day, name = date.today().isoformat(), check.name(mounting)
        file = f"{FITS}/parasitic_{name}_{day}.yaml"
        found = await self.browse_jobs.ask(
            "identify", root=str(self.data), bag=str(bag), mounting=name, date=day,
            target=str(check.inside(self.data, file, "file")),
        )  # fmt: skip
        return file, found["left"]


class PageAnalysis:
    """The analysis of one page: its open campaign and its jobs. Every request names its campaign,
    so that no page acts on that of another."""

    def __init__(self, service: AnalysisService) -> None:
        self.service = service
        self._progress: tuple[str, float] = ("", 0.0)
        self.next_run: dict[str, Any] = {}
        self._open = ""
        self._model = Path()
        self._key: Key = ("", Path())
        self._work: set[asyncio.Task[Any]] = set()

    @property
    def campaign(self) -> str:
        """The open campaign; empty without one."""
        return self._open

    @property
    def progress(self) -> tuple[str, float]:
        """Text about the present job and its completed share; empty text without a job."""
        search = self._search
        if search and not search.task.done():
            return search.progress
        return self._progress if self._work else ("", 0.0)

    @property
    def busy(self) -> bool:
        return bool(self._work) or bool(self._search and not self._search.task.done())

    @property
    def _search(self) -> Search | None:
        found = self.service.searches.get(self._key)
        return found if found and found.alive else None

    @property
    def searched(self) -> bool:
        """Whether the present model was searched, or is being searched, by whatever page."""
        return self._search is not None

    def cancel(self) -> None:
        """Cancel the running and waiting jobs of this page, and the search of its campaign."""
        for task in self._work:
            task.cancel()
        if self._search and not self._search.task.done():
            self._search.task.cancel()

    def leave(self) -> None:
        """Cancel what only this page waits for; the search of the campaign goes on."""
        search = self._search
        for task in self._work:
            if not search or task is not search.task:
                task.cancel()
        if search:
            search.pages.discard(self)
        self._work.clear()

    def close_campaign(self) -> None:
        """Close the campaign and cancel its jobs, but no search that another page shows."""
        if self._search and self._search.pages - {self}:
            self.leave()
        else:
            self.cancel()
        self._work.clear()
        self._open, self._key, self.next_run = "", ("", Path()), {}

    async def open(self, folder: str, model: str = "") -> dict[str, Any]:
        """Open a campaign; an empty `model` means its model.yaml."""
        where = self.service.folder(folder)
        path = check.inside(self.service.data, model, "model file") if model else where / MODEL
        if path.suffix != ".yaml":
            raise ValueError("a model file ends in .yaml")
        self._key = (folder, path)
        opened = await self._do("open", folder=str(where), model=str(path))
        self._open, self._model, self.next_run = folder, path, {}
        return opened

    async def allow(self, asked: ConsentNeeded) -> None:
        """Allow an effect file that the user has read to run."""
        await self._do("allow", file=asked.file, digest=asked.digest)

    async def simulate(self, folder: str, seed: Any) -> str:
        """Make a campaign with a hidden effect on the twin; returns its new folder."""
        target = check.inside(self.service.data, folder)
        made = target.relative_to(self.service.data.resolve())
        for part in made.parts or ("",):
            check.name(part)
        if target.exists():
            raise ValueError(f"{folder}: there is such a folder already; give another name")
        number = int(check.number(seed, "seed", 0, 2**31 - 1))
        await self._do("simulate", folder=str(target), seed=number)
        return str(made)

    async def compare(self) -> dict[str, Any]:
        return await self._think("compare")

    async def diagnose(self) -> dict[str, Any]:
        """Search for what the model lacks, or wait for the search that another page began."""
        self._checked()
        search = self._search
        if search is None:
            search = Search(self._task_of_search(), {self})
            self.service.searches[self._key] = search
        search.pages.add(self)
        found = await self._done(search.task)
        self.next_run = found.get("next_run") or {}
        return found

    async def add(self, effect: str) -> dict[str, Any]:
        return await self._change("add", effect=check.note(effect)[:80])

    async def undo(self) -> dict[str, Any]:
        return await self._change("undo")

    async def propose(self) -> dict[str, Any]:
        """Propose an effect file for the residual."""
        return await self._think("propose")

    async def accept(self, name: str) -> dict[str, Any]:
        """Add the last proposal to the model under a name."""
        return await self._change("accept", name=check.name(name))

    async def rename(self, old: str, new: str) -> dict[str, Any]:
        """Rename the proposal, or an effect of the model that was one."""
        return await self._change("rename", old=check.name(old), new=check.name(new))

    async def confirm(self, name: str, new: str) -> dict[str, Any]:
        """Test whether the runs of another campaign agree with an effect."""
        where = str(self.service.folder(new))
        return await self._think("confirm", name=check.name(name), new=where)

    async def report(self) -> Path:
        self._checked()
        target = check.folder_below(self.service.data, f"reports/{self._open}")
        return Path((await self._think("report", target=str(target)))["page"])

    def plan_next(self) -> Path:
        """Write the proposed run as a plan for the page Bench."""
        return write_next(self.next_run, self._checked().name, self.service.data)

    def _checked(self) -> Path:
        if not self._open:
            raise ValueError("open a campaign first")
        return self.service.folder(self._open)

    @property
    def _about(self) -> dict[str, str]:
        """Campaign and model that a job is about."""
        return {"folder": str(self._checked()), "model": str(self._model)}

    async def _think(self, job: str, **arguments: Any) -> Any:
        return await self._do(job, **self._about, **arguments)

    async def _change(self, job: str, **arguments: Any) -> Any:
        """A job that changes the model: what was found in it before is no longer so."""
        self.service.searches.pop(self._key, None)
        return await self._think(job, **arguments)

    def _task_of_search(self) -> asyncio.Task[Any]:
        key = self._key

        def say(text: str, share: float) -> None:
            if search := self.service.searches.get(key):
                search.progress = (text, share)

        return asyncio.create_task(self.service.fit_jobs.ask("diagnose", say, **self._about))

    async def _do(self, job: str, **arguments: Any) -> Any:
        if not self._work:
            self._say("", 0.0)
        return await self._done(
            asyncio.create_task(self.service.fit_jobs.ask(job, self._say, **arguments))
        )

    async def _done(self, task: asyncio.Task[Any]) -> Any:
        """Result of a task, unless the page has closed the campaign meanwhile."""
        self._work.add(task)
        await asyncio.wait([task])
        wanted = task in self._work
        self._work.discard(task)
        # the result of a closed campaign must not be shown
        if task.cancelled() or not wanted:
            raise ValueError("cancelled")
        return task.result()

    def _say(self, text: str, share: float) -> None:
        self._progress = (text, share)
