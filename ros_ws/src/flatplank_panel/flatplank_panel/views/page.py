# SPDX-License-Identifier: Apache-2.0
"""One open page: its identity, whether it is in charge, and the actions of its buttons."""

from __future__ import annotations

import inspect
import json
import logging
from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from nicegui import binding, ui

from flatplank_analysis.words import sentence
from flatplank_panel.operator import Operator
from flatplank_panel.service import AnalysisService
from flatplank_panel.views.described import described

EXPORTS = {
    "csv": "Save the points that are seen as a table",
    "png": "Save the chart as a picture",
}
"""function of export.js -> what it does"""


def _nowhere(_tab: str) -> None:
    """A page without tabs."""


async def _no_runs(_folder: str, _file: str) -> None:
    """A page without the tab Runs."""


class Page:
    """Page object, passed to every part of the page."""

    in_charge = binding.BindableProperty()

    def __init__(
        self,
        operator: Operator,
        service: AnalysisService,
        client: Any,
        shown: tuple[str, str, str] = ("", "", ""),
    ) -> None:
        """`shown`: campaign, condition and coordinate of its address."""
        self.operator, self.service = operator, service
        self.client, self.id = client, client.id
        self.in_charge = False
        self.shown = shown
        self.show_tab: Callable[[str], Any] = _nowhere
        """shows a tab; the frame says how"""
        self.open_run: Callable[[str, str], Awaitable[None]] = _no_runs
        """shows a run of a campaign; the tab Runs says how, once it was shown"""

    def take_charge(self) -> None:
        self.operator.take_charge(self.id, f"page {self.id[:4]}")

    def handler(self, work: Callable[[], Any]) -> Callable[[], Any]:
        """Event handler that does the work and shows the outcome."""

        async def handler() -> None:
            await self.run_action(work)

        return handler

    async def run_action(self, work: Callable[[], Any]) -> Any:
        """Do the work; a refusal is shown with its reason and returns None."""
        try:
            result = work()
            return await result if inspect.isawaitable(result) else result
        except (ValueError, OSError) as error:
            self._show_refusal(str(error))
        except Exception as error:
            logging.getLogger(__name__).exception("a button of the page")
            what = f"{type(error).__name__}: {error}"[:200]
            self._show_refusal(
                f"this has failed by a fault of the panel, see its terminal: {what}"
            )
        return None

    def _show_refusal(self, text: str) -> None:
        with self.client:
            ui.notify(text, type="negative", position="bottom", timeout=6000)

    # parts that every view uses
    def button(self, text: str, work: Callable[[], Any], *, strong: bool = False) -> ui.button:
        """Button for the page in charge; disabled on other pages."""
        return self.free_button(text, work, strong=strong).bind_enabled_from(self, "in_charge")

    def free_button(
        self, text: str, work: Callable[[], Any], *, strong: bool = False
    ) -> ui.button:
        """Button that works also when the page is not in charge."""
        look = "unelevated color=primary" if strong else "outline color=primary"
        return ui.button(text, on_click=self.handler(work)).props(
            f"{look} no-caps dense padding='4px 12px'"
        )

    def refresh(self, label: str, work: Callable[[], Any]) -> None:
        """Small button that reloads."""
        button = ui.button(icon="refresh", on_click=self.handler(work))
        button.props(f'flat dense round aria-label="{label}"')

    async def list_campaigns(self, field: Any) -> None:
        """Update the options of a field to the present campaigns; its choice stays."""
        found = await self.service.campaigns()
        options = {c["folder"]: f"{c['folder']} ({c['runs']} runs)" for c in found}
        deep = field.value  # one of the catalogue may be deeper than the list looks
        if deep and deep not in options and (self.service.data / deep).is_dir():
            options[deep] = deep
        field.set_options(options, value=field.value or next(iter(options), None))

    @staticmethod
    def facts(titles: Mapping[str, str]) -> None:
        """State texts of the bench with their titles."""
        with ui.element("div").classes("fp-facts"):
            for word, title in titles.items():
                ui.label(title).classes("fp-quiet")
                ui.label("–").classes("fp-word").props(f"data-word={word}")

    @staticmethod
    def chart(height: int) -> ui.echart:
        """A chart with the width of its card, hidden until it has data; height in pixels."""
        chart = ui.echart({}).style(f"height:{height}px;width:100%").props("role=img")
        Page.exports(chart).bind_visibility_from(chart, "visible")
        chart.set_visibility(False)
        return chart

    @staticmethod
    def exports(chart: ui.echart) -> ui.element:
        """The buttons that save what is seen in a chart."""
        with ui.element("div").classes("fp-row fp-exports") as row:
            for word, what in EXPORTS.items():
                button = ui.button(word.upper()).props(f'flat dense aria-label="{what}"')
                button.on("click", js_handler=f"() => fp.{word}({chart.id})").tooltip(what)
        return row

    @staticmethod
    def draw(chart: ui.echart, options: dict[str, Any]) -> None:
        """Redraw a chart with its text alternative; without data it is hidden."""
        text = described(options)
        chart.props["aria-label"] = text
        chart.set_visibility(bool(text))
        chart.options.clear()
        chart.options.update(options)
        chart.update()

    @staticmethod
    def keep(chart: ui.echart, campaign: str) -> None:
        """What is zoomed in a chart of a campaign outlives a refresh, in this browser."""
        ui.run_javascript(f"fp.keep({chart.id}, {json.dumps(f'zoom {campaign}')})")

    @staticmethod
    def number(
        label: str, value: float | None = None, unit: str = "", step: float | None = None
    ) -> Any:
        """A numeric field."""
        text = f"{label} [{unit}]" if unit else label
        field = ui.number(text, value=value, step=step)
        return field.props("outlined dense hide-bottom-space").classes("fp-number")

    @staticmethod
    def text(label: str, value: str = "") -> Any:
        return (
            ui.input(label, value=value).props("outlined dense hide-bottom-space").classes("grow")
        )

    @staticmethod
    def select(label: str, options: Any, value: Any) -> Any:
        return ui.select(options, label=label, value=value).props("outlined dense").classes("grow")

    @staticmethod
    def card(title: str, word: str = "") -> Any:
        """A card with a heading, as a context manager; the heading explains a word of the
        glossary."""
        card = ui.column().classes("fp-card w-full")
        with card:
            head = ui.label(title).classes("fp-head").props("role=heading aria-level=2")
            if word:
                head.tooltip(sentence(word))
        return card

    @staticmethod
    def row() -> Any:
        return ui.element("div").classes("fp-row")
