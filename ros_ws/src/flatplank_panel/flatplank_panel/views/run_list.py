# SPDX-License-Identifier: Apache-2.0
"""List of the runs of a campaign: filtered, sorted and paged on the server, so that a list of
thousands costs a page no more than one of ten."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Callable, Collection, Mapping
from typing import Any

from nicegui import ui

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
PER_PAGE = (12, 50, 200)
SELECT = {
    "header-selection": 'aria-label="Select all runs of this page"',
    "body-selection": ':aria-label="`Select ${props.row.file}`"',
}
"""slot of the table -> label of its checkboxes for screen readers"""
Row = dict[str, Any]


class RunList:
    """`changed` is called when other runs are shown or chosen."""

    def __init__(self, page: Page, changed: Callable[[], Any]) -> None:
        self.page, self.changed = page, changed
        self.rows: list[Row] = []
        self.shown: list[Row] = []
        """those with the words of the filter, in the order of the table"""

    def build_filter(self) -> None:
        self.find = self.page.text("Filter")
        self.find.props('clearable debounce=300 aria-label="Filter runs"')
        self.find.on_value_change(self.page.handler(self.filter))

    def build(self) -> None:
        columns = [
            {"name": k, "label": t, "field": k, "align": "left", "sortable": True}
            for k, t in COLUMNS.items()
        ]
        paging = {"page": 1, "rowsPerPage": PER_PAGE[0], "rowsNumber": 0}
        self.table = ui.table(
            columns=columns, rows=[], row_key="file", selection="multiple", pagination=paging
        )
        self.table.props(f'flat dense :rows-per-page-options="{list(PER_PAGE)}"')
        self.table.classes("fp-table w-full")
        for slot, label in SELECT.items():
            self.table.add_slot(slot, f'<q-checkbox v-model="props.selected" dense {label} />')
        self.table.on("request", lambda e: self.turn(e.args["pagination"]), ["pagination"])
        self.table.on_select(self.page.handler(self.changed))
        self.tell("Choose a campaign.")

    @property
    def chosen(self) -> list[Row]:
        """The chosen runs; all that are shown when none is chosen."""
        return self.table.selected or self.shown

    def tell(self, text: str, _share: float = 1.0) -> None:
        """What stands in the table while it has no row."""
        self.table.props["no-data-label"] = text
        self.table.update()

    def clear(self) -> None:
        self.rows, self.table.selected = [], []
        self.show()

    async def fill(self, rows: list[Row], chosen: Collection[str]) -> None:
        """Show the runs of a campaign; the `chosen` ones are selected."""
        self.rows = rows
        self.table.selected = [row for row in rows if row["file"] in chosen]
        self.tell("No run has all these words.")
        await self.filter()

    async def filter(self) -> None:
        """Show the runs with the words of the filter, from the first chosen one on."""
        self.show()
        paging, chosen = self.table.pagination, self.table.selected
        place = next((i for i, row in enumerate(self.shown) if row in chosen), 0)
        self.turn({**paging, "page": 1 + place // paging["rowsPerPage"]})
        await self.changed()

    def turn(self, paging: Mapping[str, Any]) -> None:
        """Another page, another order, or other rows per page."""
        self.table.pagination = dict(paging)
        self.show()

    def show(self) -> None:
        """Send the present page of what is shown."""
        words = str(self.find.value or "").lower().split()
        self.shown = [row for row in self.rows if all(word in _text(row) for word in words)]
        paging = self.table.pagination
        if key := paging.get("sortBy"):
            self.shown.sort(key=lambda r: natural(r[key]), reverse=bool(paging.get("descending")))
        each = paging["rowsPerPage"]
        page = min(paging["page"], max(1, -(-len(self.shown) // each)))
        self.table.pagination = {**paging, "page": page, "rowsNumber": len(self.shown)}
        self.table.rows = self.shown[(page - 1) * each : page * each]

    def update_verdicts(self, verdicts: Mapping[str, str]) -> None:
        """Update the list with verdicts from the samples."""
        for row in self.rows:
            row["verdict"] = verdicts.get(row["file"], row["verdict"])
        self.show()

    def save(self, name: str) -> None:
        """What is shown, on all its pages, as a file of the browser."""
        if not self.shown:
            raise ValueError("the list has no runs; choose a campaign first")
        file = io.StringIO()
        writer = csv.writer(file)
        writer.writerow((COLUMNS | SETTINGS).values())
        writer.writerows([row[key] for key in COLUMNS | SETTINGS] for row in self.shown)
        ui.download.content(file.getvalue(), f"{name}_runs.csv", "text/csv")


def natural(value: Any) -> list[tuple[int, int | str]]:
    """Key of an order in which run_9 comes before run_10."""
    parts = re.split(r"(\d+)", str(value).lower())
    return [(0, int(part)) if part.isdecimal() else (1, part) for part in parts if part]


def _text(row: Row) -> str:
    return " ".join(map(str, row.values())).lower()
