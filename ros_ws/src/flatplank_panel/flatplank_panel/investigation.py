# SPDX-License-Identifier: Apache-2.0
"""The investigation of this panel: one at a time, shown on every page.

An operator approves each batch or all batches. On the bench only the page in charge begins and
approves, and it must still be in charge when a batch begins, as for every measurement. On the twin
it continues without a page.
"""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from flatplank_control.runner.campaign.tires import known_tires
from flatplank_panel import validation as check
from flatplank_panel.host import presets
from flatplank_panel.operator import Operator
from flatplank_panel.service import AnalysisService

PLACES = {"bench": "on the bench", "twin": "on the twin"}
LOOK = 0.3
"""interval between checks of the runner [s]"""
STOPPED = "stopped; press Begin or go on to continue"
EMPTY: Mapping[str, Any] = {"entries": [], "waiting": None, "ended": "", "left": None}


@dataclass(frozen=True)
class PageRequest:
    """Checked request of a page."""

    folder: str
    minutes: float
    tire: str
    twin: dict[str, Any] | None
    """preset, plant file and seed; None: the bench"""


class Investigation:
    """Investigation of the panel; a ValueError is a refusal."""

    def __init__(self, service: AnalysisService, operator: Operator) -> None:
        self.service, self.operator = service, operator
        self.content: Mapping[str, Any] = EMPTY
        self.folder = ""
        self.each = True
        """true: the operator approves each batch"""
        self.last_message = ""
        self._page = ""
        """page that began, or approved last: the batches are made in its name"""
        self._on_twin = False
        self._doing: tuple[str, float] = ("", 0.0)
        self._task: asyncio.Task[None] | None = None
        self._go = asyncio.Event()
        self._asking = self._refused = self._on_bench = self._ending = False

    @property
    def busy(self) -> bool:
        """True while it runs or waits for the operator."""
        return self._task is not None and not self._task.done()

    @property
    def asking(self) -> bool:
        """True while a batch waits for approval."""
        return self.busy and self._asking

    @property
    def progress(self) -> tuple[str, float]:
        """Text about the present action with the minutes left, and its completed share."""
        if not self.busy:
            return self.last_message, 0.0
        text, share, left = *self._doing, self.content["left"]
        if self._asking:
            left += self.content["waiting"]["minutes"]
        if self._on_bench:
            p = self.operator.link.state.progress
            text, share = p.prompt or p.step or "begun", p.share
            left = None if left is None else left + p.time_left / 60.0
        return text + (f"; {left:.0f} min left" if left is not None else ""), share

    # actions of a page
    async def open(self, folder: str) -> None:
        """Show the investigation in a folder."""
        self._require_rest()
        where = check.inside(self.service.data, folder)
        self.content = await self.service.investigating.ask(
            "investigation_state", folder=str(where)
        )
        self.folder, self.last_message = (
            folder,
            "" if self.content["entries"] else "nothing is there yet",
        )

    def begin(self, page: str, request: Mapping[str, Any], each: bool) -> None:
        """Start, or continue the investigation in the folder."""
        self._require_rest()
        checked = self._checked(page, request)
        self.content, self.folder = EMPTY, str(request["folder"])
        self.each, self.last_message, self._ending = bool(each), "", False
        self._page, self._on_twin = page, checked.twin is not None
        self._go.clear()
        self._task = asyncio.create_task(self._run(checked))

    def approve_batch(self, page: str) -> None:
        """Approve the waiting batch."""
        if not self.asking:
            raise ValueError("no batch waits to be approved")
        self._answered_by(page)

    def refuse_batch(self, page: str) -> None:
        """Refuse the waiting batch; another one is chosen."""
        self.approve_batch(page)  # ends the wait, whose answer is read after this
        self._refused = True

    def run_all(self, page: str) -> None:
        """Approve this batch and all further ones."""
        if not self.busy:
            raise ValueError("no investigation is under way")
        self._answered_by(page)
        self.each = False

    async def stop(self, page: str) -> None:
        """Stop safely; it can be continued later."""
        if not self.busy or self._task is None:
            raise ValueError("no investigation is under way")
        self._ending = True
        if self._on_bench:
            await self.operator.cancel_measurement(
                page
            )  # the runner stops safely and ends the batch
        else:
            self._task.cancel()

    def _answered_by(self, page: str) -> None:
        if not self._on_twin:
            self.operator.charge.require_charge(page)
        self._page = page
        self._go.set()

    def _checked(self, page: str, request: Mapping[str, Any]) -> PageRequest:
        place = check.choice(request["place"], PLACES, "place")
        folder = check.folder_below(self.service.data, check.name(request["folder"]))
        tire = str(request["tire"] or "")
        if tire:
            check.choice(tire, known_tires(), "tire")
        if place == "bench":
            self.operator.charge.require_charge(page)
            twin = None
        else:
            plant = str(request["plant"] or "").strip()
            path = check.inside(self.service.data, plant, "plant file") if plant else None
            if path is not None and not path.is_file():
                raise ValueError(f"plant file {plant[:80]!r}: not there below the data folder")
            twin = {
                "preset": check.choice(request["preset"] or "", presets(), "preset"),
                "plant": str(path or ""),
                "seed": int(check.number(request["seed"], "seed", 0, 2**31 - 1)),
            }
        minutes = check.number(request["minutes"], "minutes", 1.0, 99_999.0, "min")
        return PageRequest(str(folder), minutes, tire, twin)

    def _require_rest(self) -> None:
        if self.busy:
            raise ValueError(f"{self.folder}: an investigation is under way; stop it first")

    # the loop
    async def _run(self, request: PageRequest) -> None:
        about = {"folder": request.folder, "minutes": request.minutes, "tire": request.tire}
        try:
            while not self._ending:
                self.content = await self._ask("choose_batch", **about)
                if self.content["waiting"] is None:
                    self.last_message = (
                        f"ended: {self.content['ended']} ({self.content['reason']})"
                    )
                    break
                if not await self._approved():
                    self.content = await self._ask("refuse_batch", **about)
                    continue
                await self._made(request, self.content["waiting"]["plan"])
                self.content = await self._ask("measure_batch", **about, twin=request.twin)
            else:  # the batch was complete when the stop came
                self.last_message = STOPPED
        except ValueError as error:
            stopped = "stopped; " if self._ending else ""
            self.last_message = f"{stopped}{error}"
        except asyncio.CancelledError:
            self.last_message = STOPPED
        finally:
            self._asking = self._on_bench = False
            self._doing = ("", 0.0)

    async def _approved(self) -> bool:
        """Wait for approval of the batch; False when it is refused."""
        if not self.each:
            return True
        self._doing, self._asking = ("waiting to be approved", 0.0), True
        try:
            await self._go.wait()
            return not self._refused
        finally:
            self._go.clear()
            self._asking = self._refused = False

    async def _made(self, request: PageRequest, plan: str) -> None:
        """Let the runner of the bench make the batch.

        On the twin the job `measure_batch` makes it.
        """
        if request.twin is not None:
            return
        state = self.operator.link.state
        await self.operator.measure(self._page, plan, self.folder)
        self._on_bench = True
        try:
            while state.progress.active:
                await asyncio.sleep(LOOK)
        finally:
            self._on_bench = False

    async def _ask(self, job: str, **arguments: Any) -> Mapping[str, Any]:
        return await self.service.investigating.ask(job, self._on_progress, **arguments)

    def _on_progress(self, text: str, share: float) -> None:
        self._doing = (text, share)
