# SPDX-License-Identifier: Apache-2.0
"""Proposals outside the library on the page Discover: propose, name, add, confirm by new runs."""

from __future__ import annotations

from typing import Any

from nicegui import ui

from flatplank_data.wording import sized
from flatplank_panel.views import charts

ASK = "When nothing of the library explains what is left, Propose writes an effect of its own."


class ProposalCard:
    """The card of a proposal on the page Discover."""

    def __init__(self, discover: Any) -> None:
        self.of = discover
        self.known = ""

    def build(self) -> None:
        """Build the card: curve and form beside the file, and the buttons."""
        page, button = self.of.page, self.of.button
        with page.card("Beyond the library") as card:
            with page.row():
                button("Propose", self.propose)
                self.words = ui.label(ASK).classes("fp-quiet grow").props("role=status")
            with ui.element("div").classes("fp-two") as effect:
                self.chart = page.chart(420)
                self.text = ui.label("").classes("fp-code")
                self.text.props('tabindex=0 role=region aria-label="Effect file"')
            with page.row() as actions:
                self.name = page.text("Name of the effect")
                button("Rename", self.rename)
                button("Add proposal", self.add)
                self.new = page.select("Campaign of new runs", [], None)
                button("Confirm", self.confirm)
        card.bind_visibility_from(self.of.error_chart, "visible")
        for part in (effect, actions):
            part.bind_visibility_from(self.text, "text", bool)

    async def propose(self) -> None:
        """Search for a proposal and show it."""
        found = await self.of.analysis.propose()
        if "name" not in found:
            self.close_campaign()
            self.show_status(f"Nothing to propose: {found['reason']}")
            return
        refit = found["refit"]
        self.show_status(
            f"Proposed: {found['sentence']}. Size "
            f"{sized(refit['size'], refit['interval'], refit['unit'])}; {found['reason']}"
            + "".join(f"; doubt: {d}" for d in refit["doubts"])
        )
        self.show_effect(found["name"], found["text"])
        self.draw(charts.proposed(found["drawn"]))
        self.new.set_options(self.of.folder.options)

    async def add(self) -> None:
        """Add the proposal to the model, under the name in the field."""
        name = str(self.name.value or "")
        picture = await self.of.analysis.accept(name)
        self.of.show_model(picture)
        self.show_effect(name, picture["text"])
        numbers = picture["added"]
        self.show_status(
            f"{name} added: error {numbers['rmse_before']:.1f} to "
            f"{numbers['rmse']:.1f} N; not confirmed yet"
        )

    async def rename(self) -> None:
        """Rename the proposal in its file and in the model."""
        new = str(self.name.value or "")
        changed = await self.of.analysis.rename(self.known, new)
        self.show_status(f"{self.known} is {new} from now on")
        self.show_effect(new, changed["text"])
        if "history" in changed:
            self.of.draw_history(changed)

    async def confirm(self) -> None:
        """Confirm the effect by runs that were not used for the fit."""
        if not self.new.value:
            raise ValueError("choose the campaign of the new runs first")
        found = await self.of.analysis.confirm(self.known, str(self.new.value))
        first = found["sets"][0]
        why = "; ".join(first["reasons"]) or "size and error agree"
        size = sized(first["size"], first["interval"], found["unit"])
        self.show_status(f"{found['verdict']}: {size} in the new runs; {why}")

    def show_effect(self, name: str, text: str) -> None:
        """Show an effect file and its name."""
        self.known = name
        self.name.set_value(name)
        self.text.set_text(text)

    def show_status(self, text: str) -> None:
        self.words.set_text(text)

    def draw(self, options: dict[str, Any]) -> None:
        self.of.page.draw(self.chart, options)

    def close_campaign(self) -> None:
        """Clear everything of the last campaign."""
        self.show_status(ASK)
        self.show_effect("", "")
        self.draw({})
