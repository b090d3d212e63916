# SPDX-License-Identifier: Apache-2.0
"""The page Runs: table of runs with verdicts and filters, curves, scatter of repeats."""

from __future__ import annotations

import csv
import io
from collections.abc import Collection, Sequence
from functools import partial
from typing import Any

from nicegui import ui

from flatplank_panel.signals import CHANNELS, OVER
from flatplank_panel.views import charts
from flatplank_panel.views.page import Page

COLUMNS = {
    "file": "Run", "condition": "Condition", "start": "Start", "order": "Order",
    "status": "Ended", "lost": "Cycles lost", "verdict": "Verdict", "notes": "Notes",
}  # fmt: skip
SETTINGS = {
    "kappa_percent": "Slip [%]", "fz": "Load [N]", "pressure": "Pressure [bar]",
    "alpha": "Side slip [deg]", "gamma": "Camber [deg]",
}  # fmt: skip
"""columns of the saved list, beside those that are shown"""
FIRST = 60
"""number of runs drawn when none is chosen"""

SELECT = {
    "header-selection": 'aria-label="Select all runs"',
    "body-selection": ':aria-label="`Select ${props.row.file}`"',
}
"""slot of the table -> label of its checkboxes for screen readers"""


def build(page: Page) -> None:
    _Runs(page).build()


class _Runs:
    def __init__(self, page: Page) -> None:
        self.page, self.service = page, page.service
        self.rows: list[dict[str, Any]] = []

    def build(self) -> None:
        page = self.page
        with ui.column().classes("fp-wide"):
            with page.card("Runs"):
                with page.row():
                    self.folder = page.select("Campaign", [], None)
                    self.find = page.text("Filter")
                    self.find.props('clearable aria-label="Filter runs"')
                    page.refresh("Look for campaigns again", self.reload)
                    save = page.free_button("CSV", self.save)
                    save.props('aria-label="Save the list as a table"')
                columns = [
                    {"name": k, "label": t, "field": k, "align": "left", "sortable": True}
                    for k, t in COLUMNS.items()
                ]
                self.table = ui.table(
                    columns=columns, rows=[], row_key="file", selection="multiple", pagination=12
                )
                self.table.props('flat dense no-data-label="Choose a campaign."').classes(
                    "fp-table w-full"
                )
                for slot, label in SELECT.items():
                    self.table.add_slot(
                        slot, f'<q-checkbox v-model="props.selected" dense {label} />'
                    )
                self.problems = ui.label("").classes("fp-quiet")
            with page.card("Curves") as curves:
                with page.row():
                    self.channel = page.select("Signal", CHANNELS, "fx")
                    self.over = page.select("Over", OVER, "plank_position")
                self.chart = page.chart(380)
                self.scatter = ui.label("").classes("fp-quiet")
            curves.bind_visibility_from(self.chart, "visible")
        self.folder.on_value_change(page.handler(self.load))
        self.find.on_value_change(page.handler(self.filter))
        self.table.on_select(page.handler(self.draw))
        self.channel.on_value_change(page.handler(self.draw))
        self.over.on_value_change(page.handler(self.draw))
        ui.timer(0.05, page.handler(partial(page.list_campaigns, self.folder)), once=True)

    async def reload(self) -> None:
        """Reload the campaigns and the chosen one."""
        before = self.folder.value
        await self.page.list_campaigns(self.folder)
        if self.folder.value == before:
            await self.load({row["file"] for row in self.table.selected})

    async def load(self, chosen: Collection[str] = ()) -> None:
        """Load the rows of the campaign; the `chosen` ones stay selected."""
        self.rows, self.table.rows, self.table.selected = [], [], []
        self.page.draw(self.chart, {})
        folder = self.folder.value
        if not folder:
            return
        try:
            found = await self.service.runs(folder, self.tell_rows)
        except ValueError as error:
            self.tell_rows(str(error))
            raise
        if self.folder.value != folder:
            return
        self.tell_rows("No run has all these words.")
        self.rows = found["rows"]
        self.table.selected = [row for row in self.rows if row["file"] in chosen]
        self.show_problems(found["problems"])
        await self.filter()

    def save(self) -> None:
        """The list as it is filtered, as a file of the browser."""
        if not self.table.rows:
            raise ValueError("the list has no runs; choose a campaign first")
        file = io.StringIO()
        writer = csv.writer(file)
        writer.writerow((COLUMNS | SETTINGS).values())
        writer.writerows([row[key] for key in COLUMNS | SETTINGS] for row in self.table.rows)
        name = f"{self.folder.value.replace('/', '_')}_runs.csv"
        ui.download.content(file.getvalue(), name, "text/csv")

    def tell_rows(self, text: str, _share: float = 1.0) -> None:
        """What stands in the table while it has no row."""
        self.table.props["no-data-label"] = text
        self.table.update()

    def tell_curves(self, text: str, _share: float) -> None:
        self.problems.set_text(text)

    def show_problems(self, problems: Sequence[str]) -> None:
        more = f" and {len(problems) - 1} more" if len(problems) > 1 else ""
        self.problems.set_text(f"Remarks: {problems[0]}{more}" if problems else "")

    def update_verdicts(self, verdicts: dict[str, str]) -> None:
        """Update the table with verdicts from the samples."""
        for row in self.rows:
            row["verdict"] = verdicts.get(row["file"], row["verdict"])
        self.table.update()

    async def filter(self) -> None:
        words = str(self.find.value or "").lower().split()
        self.table.rows = [
            r for r in self.rows if all(w in " ".join(map(str, r.values())).lower() for w in words)
        ]
        await self.draw()

    async def draw(self) -> None:
        rows = self.table.selected or self.table.rows[:FIRST]
        folder, drawn = self.folder.value, (self.channel.value, self.over.value)
        if not rows or not folder:
            self.page.draw(self.chart, {})
            return
        files = [r["file"] for r in rows]
        try:
            found = await self.service.curves(folder, files, *drawn, self.tell_curves)
        except ValueError as error:
            self.problems.set_text(str(error))
            raise
        if self.folder.value != folder:
            return
        self.show_problems(found["problems"])
        self.update_verdicts(found["verdicts"])
        channel, over = CHANNELS[drawn[0]], OVER[drawn[1]]
        self.page.draw(self.chart, charts.overlay(found["curves"], over, channel))
        self.page.keep(self.chart, folder)
        unit, scatter = channel.partition("[")[2].rstrip("]"), found["scatter"]
        names = charts.short_labels([s["condition"] for s in scatter])
        parts = [
            f"{name}: {s['scatter']:.3g} {unit}" for name, s in zip(names, scatter, strict=True)
        ]
        self.scatter.set_text("Scatter between repeats, " + "; ".join(parts) if parts else "")
