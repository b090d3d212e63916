# SPDX-License-Identifier: Apache-2.0
"""The page Runs: list of runs with verdicts and filters, curves, scatter of repeats, another
campaign over them."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from functools import partial
from typing import Any

from nicegui import ui

from flatplank_panel.signals import CHANNELS, OVER
from flatplank_panel.views import charts
from flatplank_panel.views.page import Page
from flatplank_panel.views.run_list import RunList

MOST = 60
"""number of runs drawn at most"""
NONE = ""
"""no other campaign"""


def build(page: Page) -> None:
    _Runs(page).build()


class _Runs:
    def __init__(self, page: Page) -> None:
        self.page, self.service = page, page.service
        self.list = RunList(page, self.draw)
        self.wanted = ("", "")
        """campaign and run that are to be chosen when the campaign is loaded"""
        self.asked = 0
        """number of the last drawing that was asked for; answers to earlier ones are dropped"""

    def build(self) -> None:
        page = self.page
        with ui.column().classes("fp-wide"):
            with page.card("Runs"):
                with page.row():
                    self.folder = page.select("Campaign", [], None)
                    self.list.build_filter()
                    page.refresh("Look for campaigns again", self.reload)
                    save = page.free_button("CSV", self.save)
                    save.props('aria-label="Save the list as a table"')
                self.list.build()
                self.problems = ui.label("").classes("fp-quiet")
            with page.card("Curves") as curves:
                with page.row():
                    self.channel = page.select("Signal", CHANNELS, "fx")
                    self.over = page.select("Over", OVER, "plank_position")
                    self.beside = page.select("Another campaign over it", {NONE: "none"}, NONE)
                self.chart = page.chart(420)
                self.words = ui.label("").classes("fp-quiet")
            curves.bind_visibility_from(self.chart, "visible")
        page.open_run = self.open
        self.folder.on_value_change(page.handler(self.load))
        for field in (self.channel, self.over, self.beside):
            field.on_value_change(page.handler(self.draw))
        ui.timer(0.05, page.handler(partial(page.list_campaigns, self.folder)), once=True)

    async def reload(self) -> None:
        """Reload the campaigns and the chosen one."""
        before = self.folder.value
        await self.page.list_campaigns(self.folder)
        if self.folder.value == before:
            await self.load({row["file"] for row in self.list.table.selected})

    async def open(self, folder: str, file: str) -> None:
        """Show a campaign with one of its runs chosen."""
        self.wanted = (folder, file)
        self.list.find.set_value("")
        if self.folder.value == folder:
            await self.load()
        else:
            self.folder.set_options({folder: folder} | dict(self.folder.options), value=folder)

    async def load(self, chosen: Collection[str] = ()) -> None:
        """Load the rows of the campaign; the `chosen` ones stay selected."""
        self.list.clear()
        self.page.draw(self.chart, {})
        folder = self.folder.value
        if not folder:
            return
        others = {k: v for k, v in self.folder.options.items() if k != folder}
        kept = self.beside.value if self.beside.value in others else NONE
        self.beside.set_options({NONE: "none", **others}, value=kept)
        try:
            found = await self.service.runs(folder, self.list.tell)
        except ValueError as error:
            self.list.tell(str(error))
            raise
        if self.folder.value != folder:
            return
        self.show_problems(found["problems"])
        campaign, run = self.wanted
        if campaign == folder:
            chosen, self.wanted = {run}, ("", "")
        await self.list.fill(found["rows"], chosen)

    def save(self) -> None:
        self.list.save(str(self.folder.value or "").replace("/", "_"))

    def tell_curves(self, text: str, _share: float) -> None:
        self.problems.set_text(text)

    def show_problems(self, problems: Sequence[str]) -> None:
        more = f" and {len(problems) - 1} more" if len(problems) > 1 else ""
        self.problems.set_text(f"Remarks: {problems[0]}{more}" if problems else "")

    async def draw(self) -> None:
        self.asked += 1
        rows, asked = self.list.chosen, self.asked
        folder, drawn = self.folder.value, (self.channel.value, self.over.value)
        beside = self.beside.value
        if not rows or not folder:
            self.page.draw(self.chart, {})
            return
        files = [r["file"] for r in rows[:MOST]]
        try:
            found = await self.service.curves(folder, files, *drawn, self.tell_curves, beside)
        except ValueError as error:
            self.problems.set_text(str(error))
            raise
        if self.asked != asked:
            return
        self.show_problems(found["problems"])
        self.list.update_verdicts(found["verdicts"])
        axes = OVER[drawn[1]], CHANNELS[drawn[0]]
        options = (
            charts.two_campaigns(found, (folder, beside), *axes)
            if beside
            else charts.overlay(found["curves"], *axes)
        )
        self.page.draw(self.chart, options)
        self.page.keep(self.chart, folder)
        self.words.set_text(_words(found, axes[1], len(rows), f"{beside} minus {folder}"))


def _words(found: dict[str, Any], channel: str, runs: int, pair: str) -> str:
    """What the curves say: how many there are, scatter of repeats, difference of campaigns."""
    unit = channel.partition("[")[2].rstrip("]")
    first = f"The first {MOST} of {runs} runs are drawn. " if runs > MOST else ""
    return (
        first
        + _numbers("Scatter between repeats", found["scatter"], "scatter", unit)
        + _numbers(f"{pair}, rms", found["differences"], "rms", unit)
    )


def _numbers(title: str, rows: Sequence[dict[str, Any]], number: str, unit: str) -> str:
    names = charts.short_labels([row["condition"] for row in rows]) if rows else []
    parts = [f"{name}: {row[number]:.3g} {unit}" for name, row in zip(names, rows, strict=True)]
    return f"{title}, {'; '.join(parts)}. " if parts else ""
