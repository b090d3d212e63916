# SPDX-License-Identifier: Apache-2.0
"""The page at the machine: ribbon on top, controls at the left, live plots at the right."""

from __future__ import annotations

from nicegui import ui

from flatplank_panel.views import drive, machine, measure, plots, ribbon, setup
from flatplank_panel.views.page import Page

SIDES = {
    "Machine": machine.build,
    "Drive": drive.build,
    "Measure": measure.build,
    "Set-up": setup.build,
    "Bus": machine.build_bus,
}


def build(page: Page) -> None:
    ribbon.build()
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
    """What has been done and refused, the latest first."""
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
