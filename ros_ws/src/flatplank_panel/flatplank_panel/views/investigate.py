# SPDX-License-Identifier: Apache-2.0
"""The page Investigate: the next batch with its reason and approval, and the results so far."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from nicegui import ui

from flatplank_control.runner.campaign.tires import known_tires
from flatplank_panel.host import presets
from flatplank_panel.investigation import PLACES, Investigation
from flatplank_panel.views import charts
from flatplank_panel.views.page import Page

ASK = "Begin measures, diagnoses and chooses the next runs until it is decided what is missing."


def build(page: Page, investigation: Investigation) -> None:
    _Investigate(page, investigation).build()


class _Investigate:
    def __init__(self, page: Page, investigation: Investigation) -> None:
        self.page, self.of = page, investigation
        self.drawn: Mapping[str, Any] | None = None
        # the investigation checks who may act: on the twin no page needs to be in charge
        self.button = page.free_button

    # layout
    def build(self) -> None:
        with ui.column().classes("fp-wide"):
            self.build_wishes()
            with ui.element("div").classes("fp-two"):
                self.build_next()
                self.build_verdict()
                self.build_error()
                self.build_evidence()
            self.build_queue()
        ui.timer(0.3, self.refresh)

    def build_wishes(self) -> None:
        page = self.page
        with page.card("Investigate"):
            with page.row():
                self.folder = page.text("Folder below the data folder", "investigation_1")
                self.minutes = page.number("Bench time", 90.0, "min", 10.0)
                self.place = page.select("Where", PLACES, "bench")
                self.tire = page.select(
                    "Tire", {"": "as the runs say"} | {n: n for n in known_tires()}, ""
                )
            with page.row() as twin:
                self.preset = page.select("Defects of the twin", presets(), "")
                self.plant = page.text("Plant file (below the data folder)")
                self.seed = page.number("Seed", 1.0, step=1.0)
            twin.bind_visibility_from(self.place, "value", value="twin")
            with page.row():
                self.begin = self.button("Begin or go on", self.on_begin, strong=True)
                self.look = self.button("Look", lambda: self.of.open(str(self.folder.value or "")))
                self.halt = self.button("Stop safely", lambda: self.of.stop(page.id))
                self.each = ui.switch("approve each batch", value=True)
            self.bar = ui.linear_progress(0.0, show_value=False)
            self.bar.props('instant-feedback rounded aria-label="Progress of the batch"')
            self.status = ui.label(ASK).classes("fp-quiet").props("role=status")

    def build_next(self) -> None:
        with self.page.card("Next batch") as card:
            self.what = ui.label("").classes("fp-rank-title")
        card.bind_visibility_from(self.what, "text", bool)
        with card:
            self.why = ui.label("").classes("fp-quiet")
            self.prompt = ui.label("").classes("fp-prompt")
            with self.page.row():
                self.approve = self.button(
                    "Approve", lambda: self.of.approve_batch(self.page.id), strong=True
                )
                self.refuse = self.button("Refuse", lambda: self.of.refuse_batch(self.page.id))
                self.all = self.button("Run all", lambda: self.of.run_all(self.page.id))
                self.done = self.page.button(
                    "Done, go on", lambda: self.page.operator.confirm_prompt(self.page.id)
                )

    def build_verdict(self) -> None:
        with self.page.card("Verdict so far") as card:
            self.verdict = ui.label("")
        card.bind_visibility_from(self.verdict, "text", bool)
        with card:
            self.found = ui.column().classes("w-full").style("gap:4px")
            self.sure = ui.label("").classes("fp-quiet")
            self.code = ui.label("").classes("fp-code w-full")
            self.code.props('tabindex=0 role=region aria-label="File of the proposal"')

    def build_error(self) -> None:
        with self.page.card("Error and floor", "floor") as card:
            self.error_chart = self.page.chart(240)
        card.bind_visibility_from(self.error_chart, "visible")

    def build_evidence(self) -> None:
        with self.page.card("Evidence against the tire alone", "e-value") as card:
            self.evidence_chart = self.page.chart(240)
        card.bind_visibility_from(self.evidence_chart, "visible")

    def build_queue(self) -> None:
        with self.page.card("Notebook") as self.notebook:
            self.queue = ui.column().classes("w-full").style("gap:0")
            self.file = ui.label("").classes("fp-quiet")

    # work
    def on_begin(self) -> None:
        wish = {
            "folder": self.folder.value, "minutes": self.minutes.value, "place": self.place.value,
            "tire": self.tire.value, "preset": self.preset.value, "plant": self.plant.value,
            "seed": self.seed.value,
        }  # fmt: skip
        self.of.begin(self.page.id, wish, self.each.value)

    # drawing
    def refresh(self) -> None:
        of = self.of
        text, share = of.progress
        self.status.set_text(f"{of.folder}: {text}" if text else ASK)
        self.bar.set_value(round(share, 3))
        for button, on in (
            (self.begin, not of.busy), (self.look, not of.busy), (self.halt, of.busy),
            (self.approve, of.asking), (self.refuse, of.asking), (self.all, of.busy and of.each),
        ):  # fmt: skip
            button.set_enabled(on)
        asked = self.page.operator.link.state.progress.prompt if of.busy else ""
        self.prompt.set_text(asked)
        self.prompt.set_visibility(bool(asked))
        self.done.set_visibility(bool(asked))
        if of.content is not self.drawn:
            self.drawn = of.content
            self.draw(of.content)

    def draw(self, content: Mapping[str, Any]) -> None:
        """Show the content of the log."""
        self.draw_next(content["waiting"], content["ended"], content)
        self.draw_verdict(content)
        self.queue.clear()
        with self.queue:
            for entry in content["entries"]:
                _draw_entry(entry)
        notebook = content.get("notebook")
        self.file.set_text(f"The same as a file of the folder: {notebook}" if notebook else "")
        self.page.draw(self.error_chart, charts.error_of_loop(content["entries"]))
        evidence = charts.evidence_of_loop(content["entries"], content.get("limit", 1.0))
        self.page.draw(self.evidence_chart, evidence if content["entries"] else {})
        self.notebook.set_visibility(bool(content["entries"]))

    def draw_next(self, waiting: Any, ended: str, content: Mapping[str, Any]) -> None:
        if waiting:
            self.what.set_text(f"{waiting['number']}. {waiting['what']}")
            minutes = f"{waiting['minutes']:.0f} of {content['left'] + waiting['minutes']:.0f}"
            self.why.set_text(f"{waiting['reason']}; {minutes} min left")
        else:
            self.what.set_text(f"None: {ended}" if ended else "")
            self.why.set_text(content["reason"] if ended else "")

    def draw_verdict(self, content: Mapping[str, Any]) -> None:
        self.found.clear()
        known = any(e["answer"] for e in content["entries"])
        self.verdict.set_text(
            content["verdict"] if content["ended"] else _last(content["entries"])
        )
        self.sure.set_text(f"{content['evidence']} so far; {content['decoys']}" if known else "")
        self.code.set_text(content.get("code", ""))
        self.code.set_visibility(bool(content.get("code")))
        with self.found:
            effects = content.get("effects", ())
            self.found.set_visibility(bool(effects or content.get("proposal")))
            for effect in effects:
                text = effect["text"]
                ui.label(f"{text['title']}: {text['size']}").classes("fp-rank-title")
                for m in effect["members"]:
                    ui.label(f"{m['name']}, check: {m['check']}").classes("fp-quiet")
            if content.get("proposal"):
                ui.label(content["proposal"])


def _last(entries: list[dict[str, Any]]) -> str:
    """Latest diagnosis."""
    return next((e["answer"] for e in reversed(entries) if e["answer"]), "")


def _draw_entry(e: Mapping[str, Any]) -> None:
    with ui.element("div").classes("fp-entry"):
        with ui.column().style("gap:0"):
            ui.label(f"{e['number']}. {e['what']}").classes("fp-rank-title")
            ui.label(f"{e['runs']}, {e['minutes']:.0f} min: {e['reason']}").classes("fp-quiet")
        with ui.column().style("gap:0"):
            ui.label(e["answer"] or "waits, or is under way")
            for text in (*(f"handed back: {b}" for b in e["back"]), e["evidence"]):
                if text:
                    ui.label(text).classes("fp-quiet")
