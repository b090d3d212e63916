# SPDX-License-Identifier: Apache-2.0
"""The page Discover: error of the model, its location, candidate effects, adding an effect."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any
from urllib.parse import quote, urlencode

from nicegui import ui

from flatplank_analysis.words import sentence
from flatplank_data.wording import one_of
from flatplank_panel.analysis.client import ConsentNeeded
from flatplank_panel.service import PageAnalysis
from flatplank_panel.signals import CHANNELS, OVER
from flatplank_panel.views import charts
from flatplank_panel.views.page import Page
from flatplank_panel.views.proposal import ProposalCard

WORDS = (
    ("What it is", "what"), ("How to check it", "check"), ("Runs that show it", "shown_by"),
    ("What removes it", "removes"),
)  # fmt: skip
"""text of an effect -> its key"""


def build(page: Page) -> None:
    _Discover(page).build()


class _Discover:
    def __init__(self, page: Page) -> None:
        self.page, self.service, self.analysis = page, page.service, PageAnalysis(page.service)
        self.picture: dict[str, Any] = {}
        self.ranked: list[dict[str, Any]] = []
        self.found: dict[str, Any] = {}
        self.last_message = self.wanted = self.over = ""
        self.proposal = ProposalCard(self)

    def button(self, text: str, work: Callable[[], Any], *, strong: bool = False) -> ui.button:
        """A button whose refusal stays in the status line."""

        async def told() -> Any:
            try:
                result = work()
                return await result if inspect.isawaitable(result) else result
            except ValueError as error:
                self.show_status(str(error))
                raise

        return self.page.free_button(text, told, strong=strong)

    # layout
    def build(self) -> None:
        with ui.column().classes("fp-wide"):
            self.build_bar()
            with ui.element("div").classes("fp-two"):
                self.build_error()
                self.build_waterfall()
                self.build_curves()
                self.build_map()
                self.build_ranking()
                self.build_effect()
            self.proposal.build()
        self.folder.on_value_change(self.close_campaign)
        self.page.client.on_delete(self.analysis.leave)
        ui.timer(0.05, self.page.handler(self.begin), once=True)
        ui.timer(0.3, self.refresh)

    def build_bar(self) -> None:
        page = self.page
        with page.card("Discover"):
            with page.row():
                self.folder = page.select("Campaign", [], None)
                page.refresh("Look for campaigns again", self.list)
                self.model = page.text("Model file (empty: model.yaml of the campaign)")
                self.button("Open", self.open, strong=True)
                self.button("Diagnose", self.diagnose)
                self.cancel_button = self.button("Cancel", self.analysis.cancel)
                self.button("Export report", self.report)
            with page.row():
                name = page.text("New campaign", "hidden_1")
                seed = page.number("Seed", 1.0, step=1.0)
                self.button(
                    "Simulate with a hidden effect", lambda: self.simulate(name.value, seed.value)
                )
            self.bar = ui.linear_progress(0.0, show_value=False)
            self.bar.props("aria-label=Progress rounded")
            self.status = ui.label("").classes("fp-quiet").props("role=status")
            self.show_status("Open a campaign.")

    def build_error(self) -> None:
        with self.page.card("Error against the floor", "floor") as card:
            self.error_chart = self.page.chart(260)
        card.bind_visibility_from(self.error_chart, "visible")

    def build_waterfall(self) -> None:
        with self.page.card("Waterfall: error after every step", "waterfall") as card:
            self.fall_chart = self.page.chart(260)
            with self.page.row():
                self.undo_button = self.button("Undo", self.undo)
                self.in_model = ui.label("").classes("fp-quiet")
        card.bind_visibility_from(self.fall_chart, "visible")

    def build_curves(self) -> None:
        with self.page.card("Measured and model", "residual") as card:
            self.condition = self.page.select("Condition", [], None).classes("w-full")
            self.condition.on_value_change(self.draw_curve)
            self.condition.bind_visibility_from(self.condition, "value", bool)
            self.curve_chart = self.page.chart(320)
        card.bind_visibility_from(self.curve_chart, "visible")

    def build_map(self) -> None:
        with self.page.card("Where the error is") as card:
            self.coordinate = self.page.select("Over", [], None).classes("w-full")
            self.coordinate.on_value_change(self.draw_map)
            self.map_chart = self.page.chart(300)
            self.map_text = ui.label("").classes("fp-quiet")
        card.bind_visibility_from(self.map_chart, "visible")

    def build_ranking(self) -> None:
        with self.page.card("What it may be") as card:
            self.verdict = ui.label("").classes("fp-quiet")
            with self.verdict:
                self.meaning = ui.tooltip("")
            self.list_box = ui.column().classes("w-full").style("gap:4px")
            self.to_do = ui.column().classes("w-full").style("gap:4px")
            with self.page.row():
                self.next_button = self.button("Send to the plan", self.send)
                self.next_button.set_visibility(False)
        card.bind_visibility_from(self.verdict, "text", bool)

    def build_effect(self) -> None:
        with self.page.card("The effect", "collapse") as card:
            self.effect_name = ui.label("").classes("fp-head")
            self.effect_text = ui.column().classes("w-full").style("gap:6px")
            self.collapse_chart = self.page.chart(280)
        card.bind_visibility_from(self.effect_name, "text", bool)

    # work
    async def list(self) -> None:
        await self.page.list_campaigns(self.folder)

    async def begin(self) -> None:
        """List the campaigns; open that of the address, with what its last search has found."""
        await self.list()
        folder, self.wanted, self.over = self.page.shown
        if folder not in self.folder.options:
            return
        self.folder.set_value(folder)
        await self.open()
        if self.analysis.searched:
            await self.diagnose()

    def say_where(self) -> None:
        """The address of what is shown, so that it can be loaded again and sent to others."""
        if self.analysis.campaign:
            shown = {"condition": self.condition.value, "over": self.coordinate.value}
            query = urlencode({key: value for key, value in shown.items() if value})
            ui.navigate.history.replace(f"/discover/{quote(self.analysis.campaign)}?{query}")

    async def simulate(self, name: str, seed: Any) -> None:
        self.close_campaign()
        made = await self.analysis.simulate(name, seed)
        await self.list()
        self.folder.set_value(made)
        self.show_status(f"{made}: something is hidden in it; open the campaign and diagnose it")

    async def open(self) -> None:
        if not self.folder.value:
            raise ValueError("choose a campaign first")
        self.close_campaign()
        folder, model = self.folder.value, str(self.model.value or "")
        await self.first_picture(folder)
        if self.folder.value != folder:
            return
        if folder != self.page.shown[0]:
            ui.navigate.history.push(f"/discover/{quote(folder)}")
        self.page.shown = (folder, "", "")
        opened = await self.opened(folder, model)
        self.draw_history(opened)
        if opened["undecidable"]:
            self.show_status(opened["undecidable"])
            return
        self.show_model(await self.analysis.compare())

    async def opened(self, folder: str, model: str) -> dict[str, Any]:
        """Open a campaign; the user is asked about each Python file that its model would run."""
        while True:
            try:
                return await self.analysis.open(folder, model)
            except ConsentNeeded as asked:
                if not await self.may_run(asked):
                    raise
                await self.analysis.allow(asked)

    async def may_run(self, asked: ConsentNeeded) -> bool:
        """Show an effect file and ask whether it may run."""
        with self.page.client, ui.dialog().props("persistent") as dialog, ui.card():
            ui.label("The model of this campaign runs Python").classes("fp-head")
            ui.label(f"{asked.file}: read it first. It may do whatever you may do.")
            ui.label(asked.text).classes("fp-code").props(
                'tabindex=0 role=region aria-label="Python of the model"'
            )
            with self.page.row():
                self.button("Let it run", lambda: dialog.submit(True))
                self.button("Do not run it", lambda: dialog.submit(False))
        allowed = bool(await dialog)
        dialog.delete()
        return allowed

    async def first_picture(self, folder: str) -> None:
        """Show measured curves before the first fit."""
        rows = (await self.service.runs(folder, self.tell))["rows"]
        files = [r["file"] for r in rows[:60]]
        found = await self.service.curves(folder, files, "fx", "plank_position", self.tell)
        options = charts.overlay(found["curves"], OVER["plank_position"], CHANNELS["fx"])
        self.page.draw(self.curve_chart, options)
        self.page.keep(self.curve_chart, folder)

    async def diagnose(self) -> None:
        self.found = await self.analysis.diagnose()
        self.ranked = self.found["ranked"]
        f = self.found
        took = f" ({f['seconds']:.0f} s)" if f.get("seconds") else ""
        self.show_status(f"{f['verdict']}: {f['reason']}{took}")
        self.verdict.set_text(f"Verdict: {f['verdict']}: {f['reason']}")
        self.meaning.set_text(sentence(f["verdict"]))
        self.draw_ranking()
        self.draw_to_do(f["to_do"])
        self.next_button.set_visibility(bool((f.get("next_run") or {}).get("settings")))
        if f["effects"]:
            self.show(f["effects"][0]["name"])

    async def add(self, name: str) -> None:
        picture = await self.analysis.add(name)
        numbers = picture["added"]
        self.show_model(picture)
        others = [m["name"] for m in numbers.get("class", ())]
        self.show_status(
            f"{one_of([name, *others])} added: error {numbers['rmse_before']:.1f} to "
            f"{numbers['rmse']:.1f} N, floor {numbers['floor']:.1f} N"
        )

    async def undo(self) -> None:
        picture = await self.analysis.undo()
        self.show_model(picture)
        self.show_status(f"{picture['undone']} undone")

    async def report(self) -> None:
        path = await self.analysis.report()
        self.show_status(f"report: {path}")

    def send(self) -> None:
        path = self.analysis.plan_next()
        self.show_status(
            f"plan written: {path.name}; the page Bench offers it under Measure, Campaign"
        )

    # drawing
    def tell(self, text: str, _share: float) -> None:
        self.show_status(f"{text} …")

    def show_status(self, text: str) -> None:
        self.last_message = text
        self.status.set_text(text)

    def refresh(self) -> None:
        text, share = self.analysis.progress
        self.bar.set_value(round(share, 2))
        self.cancel_button.set_enabled(self.analysis.busy)
        self.status.set_text(f"{text} …" if text else self.last_message)

    def close_campaign(self) -> None:
        """Close the campaign and clear all results."""
        self.analysis.close_campaign()
        self.picture, self.ranked, self.found = {}, [], {}
        for text in (self.effect_name, self.map_text, self.in_model, self.verdict):
            text.set_text("")
        self.proposal.close_campaign()
        self.show_status("Open the campaign.")
        self.next_button.set_visibility(False)
        for box in (self.list_box, self.effect_text, self.to_do):
            box.clear()
        for field in (self.condition, self.coordinate):
            field.set_options([], value=None)
        for chart in (
            self.error_chart, self.fall_chart, self.curve_chart, self.map_chart,
            self.collapse_chart,
        ):  # fmt: skip
            self.page.draw(chart, {})

    def show_model(self, picture: dict[str, Any]) -> None:
        """Redraw everything for a fitted model."""
        self.picture = picture
        self.show_status(
            f"error {picture['rmse']:.1f} N, floor {picture['floor']:.1f} N, "
            f"beyond the floor {picture['beyond']:.1f} N; the floor is from "
            f"{picture['floor_from']}"
        )
        self.page.draw(self.error_chart, charts.against_floor(picture["conditions"]))
        names = [c["condition"] for c in picture["curves"]]
        worst = max(picture["conditions"], key=lambda c: c["floors"])["condition"]
        kept = self.wanted or self.condition.value
        shown, self.wanted = kept if kept in names else worst, ""
        self.condition.set_options(names, value=shown)
        over = [m["coordinate"] for m in picture["maps"]]
        kept, self.over = self.over or self.coordinate.value, ""
        self.coordinate.set_options(over, value=kept if kept in over else next(iter(over), None))
        self.draw_curve()
        self.draw_map()
        self.draw_history(picture)

    def draw_history(self, model: dict[str, Any]) -> None:
        history = model["history"]
        if not history and "rmse" in model:
            history = [{"action": "start", **{k: model[k] for k in ("rmse", "floor", "held_out")}}]
        self.page.draw(self.fall_chart, charts.waterfall(history))
        names = ", ".join(e["text"] for e in model["effects"]) or "no effect yet"
        self.in_model.set_text(f"In {Path(model['file']).name}: {names}")
        self.undo_button.set_enabled(len(model["history"]) > 1)

    def draw_curve(self) -> None:
        for curve in self.picture.get("curves", []):
            if curve["condition"] == self.condition.value:
                self.say_where()
                self.page.draw(self.curve_chart, charts.measured_and_model(curve))

    def draw_map(self) -> None:
        names = [c["condition"] for c in self.picture.get("conditions", [])]
        for m in self.picture.get("maps", []):
            if m["coordinate"] == self.coordinate.value:
                self.say_where()
                self.page.draw(self.map_chart, charts.residual_map(m, names))
                self.map_text.set_text(m["text"])

    def draw_ranking(self) -> None:
        self.list_box.clear()
        with self.list_box:
            for row in self.rows():
                with ui.element("div").classes("fp-rank"):
                    ui.label(_title(row)).classes("fp-rank-title")
                    ui.label(_words(row)).classes("fp-quiet fp-rank-why")
                    self.row_button("Show", self.show, row["name"])
                    with ui.row().style("gap:4px"):
                        for member in row["members"]:
                            self.row_button("Add", self.add, member["name"], row["members"])

    def row_button(
        self, word: str, work: Callable[..., Any], name: str, of: Sequence[Any] = ()
    ) -> None:
        """A button of a row; those of the members of a class have their names."""
        button = self.button(f"{word} {name}" if len(of) > 1 else word, partial(work, name))
        button.props(f'aria-label="{word} {name}"')

    def rows(self) -> Sequence[dict[str, Any]]:
        """What was found, each class as one row, and below it other effects of the ranking."""
        found = self.found.get("effects", [])
        known = {m["name"] for e in found for m in e["members"]}
        others = sorted((r for r in self.ranked if r["name"] not in known), key=_gain)
        return [*found, *others][:8]

    def draw_to_do(self, tasks: Sequence[dict[str, Any]]) -> None:
        self.to_do.clear()
        with self.to_do:
            if tasks:
                ui.label("What to do, in this order").classes("fp-rank-title")
            for number, task in enumerate(tasks, 1):
                ui.label(f"{number}. {task['do']}" + (":" if task["each"] else ""))
                for one in task["each"]:
                    ui.label(f"{one['name']}: {one['text']}").classes("fp-quiet")

    def show(self, name: str) -> None:
        row = next(r for r in self.rows() if r["name"] == name)
        self.effect_name.set_text(_title(row))
        self.effect_text.clear()
        with self.effect_text:
            for member in row["members"]:
                if len(row["members"]) > 1:
                    ui.label(member["title"]).classes("fp-rank-title")
                for head, key in WORDS:
                    if member[key]:
                        ui.label(f"{head}: {member[key]}")
        drawn = [c for c in self.found.get("collapse", []) if c["name"] == name]
        self.page.draw(self.collapse_chart, charts.collapse(drawn[0]) if drawn else {})


def _gain(row: dict[str, Any]) -> float:
    return -row["gain"]


def _title(row: dict[str, Any]) -> str:
    """'A or B' of a class."""
    return row["text"]["title"] if "text" in row else row["members"][0]["title"]


def _words(row: dict[str, Any]) -> str:
    if "text" in row:
        return f"found: {row['text']['size']}"
    if row.get("reasons"):
        return "refused: " + row["reasons"][0]
    return (
        "not visible here"
        if not row["visible"]
        else f"not tried; χ² would fall by {row['gain']:.0f}"
    )
