# SPDX-License-Identifier: Apache-2.0
"""The ribbon: all measured signals as numbers (R1.IV), and the words that matter."""

from __future__ import annotations

from nicegui import ui

from flatplank_panel.signals import BY_KEY, RIBBON

WORDS = (("trigger", "Trigger"), ("run", "Recording"), ("filter", "Filter"))


def build() -> None:
    """Cells are filled by the live data: `data-key` numbers, `data-word` words."""
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
