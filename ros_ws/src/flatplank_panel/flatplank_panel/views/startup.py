# SPDX-License-Identifier: Apache-2.0
"""Start-up of the bench, walked step by step: the first step that is not done has its button."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any

from nicegui import ui

from flatplank_panel import startup
from flatplank_panel.views.page import Page

READY = "Ready to measure: the tab Measure asks for load, pressure and angles."
Buttons = Mapping[str, tuple[str, Callable[[], Any]]]
"""name of a step -> text of its button, and what the button does"""


def build(page: Page, start: Callable[[], Any]) -> None:
    """`start`: starts the bench that is chosen on the page."""
    op = page.operator
    buttons: Buttons = {
        "charge": ("Take charge now", page.take_charge),
        "bench": ("Start it", start),
        "estop": ("Release it", lambda: op.release_emergency_stop(page.id)),
        "zero": ("Take it", lambda: op.tare(page.id)),
        "enable": ("Enable it", lambda: op.enable(page.id, True)),
    }
    with page.card("Start-up"):
        box = ui.column().classes("w-full").style("gap:2px").props("role=list")
    shown: dict[str, startup.Step] = {}

    def refresh() -> None:
        words = op.link.state.state_texts(time.monotonic())
        steps = startup.steps(page.in_charge, words, op.link.state.zero_taken)
        if shown == steps:
            return
        shown.clear()
        shown.update(steps)
        box.clear()
        with box:
            _rows(page, steps, buttons)

    refresh()
    ui.timer(0.3, refresh)


def _rows(page: Page, steps: Mapping[str, startup.Step], buttons: Buttons) -> None:
    following = startup.next_of(steps)
    if not following:
        ui.label(READY).props("role=listitem")
        return
    for number, (name, step) in enumerate(steps.items(), 1):
        with page.row().props("role=listitem"):
            ui.label(f"{number}. {step.title}")
            ui.space()
            ui.label("done" if step.done else "now" if name == following else "open").classes(
                "fp-quiet"
            )
        if name == following:
            with ui.column().classes("fp-prompt").style("gap:6px").props("role=listitem"):
                ui.label(step.to_do).classes("fp-quiet")
                if name in buttons:
                    word, work = buttons[name]
                    page.free_button(word, work, strong=True)
