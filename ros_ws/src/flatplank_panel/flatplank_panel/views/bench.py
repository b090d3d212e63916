# SPDX-License-Identifier: Apache-2.0
"""The page at the machine: ribbon on top, controls at the left, live plots at the right."""

from __future__ import annotations

from nicegui import ui

from flatplank_panel.signals import BY_KEY, RIBBON
from flatplank_panel.views import drive, machine, measure, plots, setup
from flatplank_panel.views.page import Page

SIDES = {
    "Machine": machine.build,
    "Drive": drive.build,
    "Measure": measure.build,
    "Set-up": setup.build,
    "Bus": machine.build_bus,
}

WORDS = (("trigger", "Trigger"), ("run", "Recording"), ("filter", "Filter"))


def build(page: Page) -> None:
    _ribbon()
    with ui.element("div").classes("fp-main"):
        with ui.column().classes("fp-side"):
            with ui.tabs().props("dense no-caps align=left active-color=primary") as bar:
                for name in SIDES:
                    ui.tab(name)
            with (
                ui.tab_panels(bar, value="Machine", animated=False)
                .props("keep-alive")
                .classes("w-full bg-transparent")
            ):
                for name, part in SIDES.items():
                    with ui.tab_panel(name), ui.column().classes("fp-side"):
                        part(page)
            _log(page)
        plots.build(page)


def _log(page: Page) -> None:
    """Log of actions and refusals, the latest first."""
    with page.card("Log"):
        lines = ui.column().classes("fp-log").props('role=log aria-label="Log" tabindex=0')
    shown: list[tuple[str, str]] = []

    def refresh() -> None:
        latest = list(page.operator.link.state.log)[:12]
        if latest == shown:
            return
        shown[:] = latest
        lines.clear()
        with lines:
            for at, text in latest:
                ui.label(f"{at}  {text}").classes("fp-log-line")

    ui.timer(0.3, refresh)


def _ribbon() -> None:
    """Ribbon of cells that live data fill: `data-key` for numbers, `data-word` for texts."""
    with ui.element("section").classes("fp-ribbon").props('aria-label="Measured signals"'):
        for title, names in RIBBON:
            with ui.column().classes("fp-group"):
                ui.label(title).classes("fp-group-name")
                with ui.element("div").classes("fp-cells"):
                    for key, name in names.items():
                        _cell(key, name)
        with ui.column().classes("fp-group"):
            ui.label("Measurement").classes("fp-group-name")
            with ui.element("div").classes("fp-cells"):
                for word, title in WORDS:
                    with ui.column().classes("fp-cell"):
                        ui.label("–").classes("fp-word").props(f"data-word={word}")
                        ui.label(title).classes("fp-unit")


def _cell(key: str, name: str) -> None:
    signal = BY_KEY[key]
    with ui.column().classes("fp-cell"):
        ui.label("–").classes("fp-value").props(f"data-key={key}")
        ui.label(f"{name} [{signal.unit}]").classes("fp-unit")
