# SPDX-License-Identifier: Apache-2.0
"""The wheel drive: enable, fault, the six operation modes and their inputs (R1.VII to R1.IX)."""

from __future__ import annotations

from functools import partial

from nicegui import ui

from flatplank_panel.operator import PREDETERMINED, VALUES
from flatplank_panel.views import waveform
from flatplank_panel.views.page import Page

FACTS = {"state": "State", "mode": "Mode", "stop": "Held because", "error": "Error"}


def build(page: Page) -> None:
    op = page.operator
    with page.card("Drive"):
        with ui.element("div").classes("fp-facts"):
            for word, title in FACTS.items():
                ui.label(title).classes("fp-quiet")
                ui.label("–").classes("fp-word").props(f"data-word={word}")
        with page.row():
            page.button("Enable", lambda: op.enable(page.id, True), strong=True)
            page.button("Disable", lambda: op.enable(page.id, False))
            page.button("Reset fault", lambda: op.reset_fault(page.id))
            page.button("Quick stop", lambda: op.quick_stop(page.id))
    with page.card("Position"):
        with page.row():
            for angle in PREDETERMINED:
                page.button(f"{angle:g}°", partial(op.move_to, page.id, angle))
        with page.row():
            target = page.number("Angle", 0.0, "deg")
            page.button("Turn there", lambda: op.move_to(page.id, target.value))
            page.button("Home: this is 0°", lambda: op.set_mode(page.id, "homing"))
    with page.card("Longitudinal slip"):
        waveform.build(page)
    with page.card("Velocity, torque, free rolling"):
        for mode, start in (("velocity", 0.05), ("torque", 1.0)):
            _value(page, mode, start)
        with page.row():
            page.button("Free rolling", lambda: op.set_mode(page.id, "free_rolling"))
            ui.label("holds Fx near zero (50 N, thesis 5.5) while the plank moves").classes(
                "fp-quiet"
            )


def _value(page: Page, mode: str, start: float) -> None:
    what, unit, _, _ = VALUES[mode]
    with page.row():
        field = page.number(what.capitalize(), start, unit)
        page.button(f"Set {what}", lambda: page.operator.set_mode(page.id, mode, field.value))
