# SPDX-License-Identifier: Apache-2.0
"""The page Catalogue: the runs below the data folder by conditions; control charts of a tire."""

from __future__ import annotations

import asyncio
import base64
from collections.abc import Mapping
from functools import partial
from typing import Any

from nicegui import ui

from flatplank_analysis.catalogues.conditions import CONDITIONS
from flatplank_analysis.catalogues.shown import COLUMNS
from flatplank_panel.views.page import Page
from flatplank_panel.views.run_list import PER_PAGE

AS = "tire=TOY pressure=2.5bar load=3000..4000 since=2026-05-01"
"""an example of conditions"""
OPENS = """
<q-td :props="props"><button type="button" class="fp-link">{{ props.value }}</button></q-td>
"""
"""cell of a run; the click is that of its row, the button is for the keyboard"""


def build(page: Page) -> None:
    _Catalogue(page).build()


class _Catalogue:
    def __init__(self, page: Page) -> None:
        self.page, self.service = page, page.service
        self.where = ""
        """conditions of the runs that are shown"""
        self.asked = 0
        """number of the last question; answers to earlier ones are dropped"""
        self.charting: asyncio.Task[dict[str, Any]] | None = None

    # layout
    def build(self) -> None:
        with ui.column().classes("fp-wide"):
            self.build_runs()
            self.build_chart()
        self.page.client.on_delete(self.cancel)
        ui.timer(0.05, self.page.handler(self.find), once=True)

    def build_runs(self) -> None:
        page = self.page
        with page.card("Catalogue of all runs"):
            with page.row():
                self.line = page.text("Conditions").props("clearable")
                self.line.on("keydown.enter", page.handler(self.find))
                page.free_button("Find", self.find, strong=True)
                page.refresh("Look for what changed", self.look_again)
            ui.label(f"As {AS}; keys: {', '.join(CONDITIONS)}").classes("fp-quiet")
            self.bar = ui.linear_progress(0.0, show_value=False)
            self.bar.props('instant-feedback rounded aria-label="Progress of the catalogue"')
            self.bar.set_visibility(False)
            self.status = ui.label("").classes("fp-quiet").props("role=status")
            self.build_table()
            with ui.expansion("").classes("fp-quiet w-full") as self.unusable:
                self.errors = ui.label("").style("white-space:pre-line")
            self.unusable.set_visibility(False)

    def build_table(self) -> None:
        columns = [
            {"name": name, "label": column.head[0].upper() + column.head[1:], "field": name,
             "sortable": True, "align": "right" if column.unit else "left"}
            for name, column in COLUMNS.items()
        ]  # fmt: skip
        paging = {"page": 1, "rowsPerPage": PER_PAGE[0], "rowsNumber": 0}
        self.table = ui.table(columns=columns, rows=[], row_key="key", pagination=paging)
        self.table.props(f'flat dense :rows-per-page-options="{list(PER_PAGE)}"')
        self.table.props('no-data-label="No run."').classes("fp-table w-full")
        self.table.add_slot("body-cell-file", OPENS)
        act = self.page.run_action
        self.table.on(
            "request", lambda e: act(partial(self.turn, e.args["pagination"])), ["pagination"]
        )
        self.table.on(
            "rowClick", lambda e: act(partial(self.open, e.args[1])), [[], ["folder", "file"], []]
        )

    def build_chart(self) -> None:
        page = self.page
        with page.card("Control charts of the reference tire"):
            ui.label(
                "The runs that were found, of one tire: a session per campaign, a panel per bench."
            ).classes("fp-quiet")
            with page.row():
                self.draw_button = page.free_button("Draw", self.draw)
                self.cancel_button = page.free_button("Cancel", self.cancel)
            self.cancel_button.set_enabled(False)
            self.told = ui.label("").classes("fp-quiet").props("role=status")
            self.pictures = ui.element("div").classes("fp-two")

    # runs
    async def find(self) -> None:
        """Show the runs that fulfil the conditions of the line."""
        await self.ask(str(self.line.value or ""), {**self.table.pagination, "page": 1})

    async def look_again(self) -> None:
        await self.ask(str(self.line.value or ""), self.table.pagination, again=True)

    async def turn(self, paging: Mapping[str, Any]) -> None:
        """Another page, another order, or other rows per page."""
        await self.ask(self.where, paging)

    async def ask(self, where: str, paging: Mapping[str, Any], again: bool = False) -> None:
        """Show a page of the runs; a refusal stands below the line."""
        self.asked += 1
        asked, each = self.asked, paging["rowsPerPage"]
        try:
            found = await self.service.catalogue(
                where, self.tell, order=paging.get("sortBy") or "", again=again, count=each,
                descending=bool(paging.get("descending")), first=(paging["page"] - 1) * each,
            )  # fmt: skip
        except ValueError as error:
            if self.asked == asked:
                self.bar.set_visibility(False)
                self.line.error = str(error).removeprefix("where: ")
            return
        if self.asked == asked:
            self.where, self.line.error = where, None
            self.show(found, paging)

    def tell(self, text: str, share: float) -> None:
        self.bar.set_visibility(True)
        self.bar.set_value(round(share, 3))
        self.status.set_text(f"{text} …")

    def show(self, found: Mapping[str, Any], paging: Mapping[str, Any]) -> None:
        self.bar.set_visibility(False)
        as_of = f"as of {found['looked']}"
        if not found["kept"]:
            as_of += "; the data folder cannot be written: the catalogue is made anew each time"
        some = f"{found['size']} of the " if self.where else ""
        self.status.set_text(f"{some}{found['of']} runs in {found['folders']} folders, {as_of}")
        self.table.pagination = {**paging, "rowsNumber": found["size"]}
        self.table.rows = [
            {**row, "key": f"{row['folder']}/{row['file']}"} for row in found["rows"]
        ]
        errors = found["errors"]
        self.unusable.set_text(f"{found['unusable']} files cannot be used")
        self.errors.set_text("\n".join(errors))
        self.unusable.set_visibility(bool(errors))

    async def open(self, row: Mapping[str, Any]) -> None:
        """The campaign of a run on the page Runs."""
        self.page.show_tab("Runs")
        await self.page.open_run(row["folder"], row["file"])

    # control charts
    async def draw(self) -> None:
        """Draw the control charts of the runs that are shown; the page stays while it is done."""
        self.cancel()
        self.pictures.clear()
        self.charting = asyncio.create_task(self.service.reference_chart(self.where, self.say))
        self.set_busy(True)
        try:
            found = await self.charting
        except asyncio.CancelledError:
            self.told.set_text("cancelled")
            return
        except ValueError as error:
            self.told.set_text(str(error))
            return
        finally:
            self.set_busy(False)
        page = found["page"].removeprefix(f"{self.service.data}/")
        self.told.set_text(f"page with all numbers, below the data folder: {page}")
        with self.pictures:
            for figure in found["figures"]:
                self.show_figure(figure)

    def set_busy(self, busy: bool) -> None:
        self.draw_button.set_enabled(not busy)
        self.cancel_button.set_enabled(busy)

    def say(self, text: str, _share: float) -> None:
        self.told.set_text(f"{text} …")

    def cancel(self) -> None:
        if self.charting:
            self.charting.cancel()

    @staticmethod
    def show_figure(figure: Mapping[str, str]) -> None:
        drawn = base64.b64encode(figure["svg"].encode()).decode()
        with ui.column().style("gap:4px"):
            ui.label(figure["title"]).classes("fp-rank-title")
            picture = ui.element("img").classes("fp-figure")
            picture.props["src"] = f"data:image/svg+xml;base64,{drawn}"
            picture.props["alt"] = figure["title"]
            ui.label(figure["caption"]).classes("fp-quiet")
