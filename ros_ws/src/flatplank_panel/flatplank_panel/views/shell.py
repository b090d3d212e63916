# SPDX-License-Identifier: Apache-2.0
"""Frame of the page, always visible: title, tabs, who is in charge, and the stop button."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping

from nicegui import ui
from nicegui.events import KeyEventArguments

from flatplank_panel.operator import Operator
from flatplank_panel.views.page import Page

HEAD = """
<link rel="stylesheet" href="/assets/panel.css">
<script src="/assets/panel.js"></script>
<script src="/assets/export.js"></script>
<script>document.documentElement.lang = "en"</script>
"""
NOBODY = "nobody is in charge"
STOP, STOP_KEY, KEYED = "Stop wheel and plank", "Escape", "Bench"
"""what the stop button does, its key, and the tab on which the key acts"""


def build(page: Page, tabs: Mapping[str, Callable[[Page], None]], first: str) -> None:
    """Build the frame with one panel per tab; a panel is built when it is first shown."""
    ui.colors(primary="#1f5488", negative="#b3261e", positive="#1f6f43", warning="#8a5a00")
    ui.add_head_html(HEAD)
    with ui.header(elevated=False).classes("fp-header items-center no-wrap"):
        ui.label("Flat Plank").classes("fp-title")
        with ui.tabs().props("dense no-caps indicator-color=primary active-color=primary") as bar:
            for name in tabs:
                ui.tab(name)
        ui.space()
        with ui.row().classes("items-center no-wrap").style("gap:6px"):
            ui.label("Bench").classes("fp-quiet")
            ui.label("–").classes("fp-word").props("data-word=bench")
        _charge(page)
        stopping = page.handler(lambda: _stop(page))
        stop = ui.button("STOP", on_click=stopping)
        stop.classes("fp-stop").props(f'unelevated color=negative aria-label="{STOP}"').tooltip(
            f"{STOP}; key {STOP_KEY}. The mushroom button at the machine is the emergency stop."
        )

    def pressed(event: KeyEventArguments) -> Awaitable[None] | None:
        once = event.action.keydown and not event.action.repeat and bar.value == KEYED
        return stopping() if once and event.key.name == STOP_KEY else None

    ui.keyboard(on_key=pressed, ignore=[])
    built: set[str] = set()
    panels = (
        ui.tab_panels(bar, value=first, animated=False)
        .props("keep-alive")
        .classes("w-full bg-transparent")
    )
    slots = {}
    with panels:
        for name in tabs:
            with ui.tab_panel(name) as slot:
                slots[name] = slot

    def show(name: str) -> None:
        if name not in built:
            built.add(name)
            with slots[name]:
                tabs[name](page)

    show(first)

    def chosen(name: str) -> None:
        show(name)
        ui.navigate.history.replace(f"/?tab={name}")

    panels.on_value_change(lambda e: chosen(e.value))
    page.show_tab = panels.set_value


async def _stop(page: Page) -> None:
    text = await page.operator.emergency_stop(page.id)
    with page.client:
        ui.notify(text, type="positive", position="bottom", timeout=6000)


def _charge(page: Page) -> None:
    operator: Operator = page.operator
    label = ui.label().classes("fp-quiet")

    async def toggle() -> None:
        if page.in_charge:
            await operator.release_page(page.id)
        else:
            page.take_charge()
        refresh()

    button = ui.button(on_click=page.handler(toggle)).props(
        "outline no-caps dense padding='4px 12px'"
    )

    def refresh() -> None:
        mine = operator.charge.holder == page.id
        if mine != page.in_charge:
            page.in_charge = mine
            ui.run_javascript(f"fp.charge({'true' if mine else 'false'})")
        button.set_text("Hand back" if mine else "Take charge")
        holder = operator.charge.name if operator.charge.holder else ""
        label.set_text(
            "you are in charge" if mine else f"{holder} is in charge" if holder else NOBODY
        )

    refresh()
    ui.timer(0.3, refresh)
    ui.on("beat", lambda: operator.register_heartbeat(page.id))
