# SPDX-License-Identifier: Apache-2.0
"""Start and stop of the bench, manual settings of the simulated machine, state of the bus."""

from __future__ import annotations

import time
from typing import Any

from nicegui import ui

from flatplank_data.limits import LIMITS
from flatplank_data.machine import FAST
from flatplank_panel.host import KINDS, USUAL, interfaces, presets, simulated_tires
from flatplank_panel.operator import HANDS
from flatplank_panel.views import startup
from flatplank_panel.views.page import Page

START_VALUES = {"load_to": 3700.0, "pressure": 2.5}
"""start values of the manual settings; 0 for all others"""
FACTS = {
    "bench": "Bench", "health": "Health", "cycle": "Cycle", "estop": "Emergency stop",
    "plank": "Plank", "saturated": "Saturated channels", "late": "Late cycles",
    "troubles": "Troubles",
}  # fmt: skip
DRIVE_COLUMNS = {
    "axis": "Axis", "state": "State", "word": "Status", "mode": "Mode", "error": "Error",
}  # fmt: skip

TIMES = {
    "wake_up": "Wake-up", "frame_to_frame": "Frame to frame",
    "stamp_to_command": "Stamp to command", "round_trip": "Round trip of a frame",
}  # fmt: skip


def build(page: Page) -> None:
    op = page.operator
    fields: dict[str, Any] = {}

    def start() -> Any:
        return op.start_bench(page.id, {k: f.value for k, f in fields.items()})

    startup.build(page, start)
    with page.card("Bench"):
        with page.row():
            kind = page.select("Kind", KINDS, "sim")
            rate = page.number("Bus rate", 250, "Hz")
        with page.row().bind_visibility_from(kind, "value", lambda k: k != "lab"):
            tire = page.select("Simulated tire", simulated_tires(), USUAL.tire)
            preset = page.select("Defects", presets(), "")
            seed = page.number("Seed", 1)
        with page.row().bind_visibility_from(kind, "value", value="lab"):
            interface = page.select("Network interface", interfaces(), None)
            bus_file = page.text("Bus file", "bench")
        fields |= {
            "kind": kind, "rate": rate, "tire": tire, "preset": preset, "seed": seed,
            "interface": interface, "bus_file": bus_file,
        }  # fmt: skip
        with page.row():
            page.button("Start bench", start, strong=True)
            page.button("Stop bench", lambda: op.stop_bench(page.id))
    with page.card("Simulated machine: settings made by hand"):
        with page.row():
            page.button(
                "Plank forward", lambda: op.move_plank(page.id, 1, fast.value, stop_at.value)
            )
            page.button("Stop plank", lambda: op.move_plank(page.id, 0))
            page.button("Plank back", lambda: op.move_plank(page.id, -1, fast.value, 0.0))
        with page.row():
            fast = ui.switch(f"Fast ({FAST:.4f} m/s)", value=True)
            stop_at = page.number("Stops at", 4.1, "m")
        for what, (label, setting) in HANDS.items():
            _hand(page, what, label, LIMITS[setting].unit)
        with page.row():
            page.button("Lift the wheel", lambda: op.unload(page.id))
            page.button("Release emergency stop", lambda: op.release_emergency_stop(page.id))


def _hand(page: Page, what: str, label: str, unit: str) -> None:
    with page.row():
        field = page.number(label, START_VALUES.get(what, 0.0), unit).classes("grow")
        page.button("Set", lambda: page.operator.set_by_hand(page.id, what, field.value)).props(
            f'aria-label="Set {label}"'
        )


def build_bus(page: Page) -> None:
    """State of the bus (R1.X)."""
    with page.card("Bus"):
        page.facts(FACTS)
    with page.card("Drives on the bus"):
        columns = [
            {"name": key, "label": title, "field": key, "align": "left"}
            for key, title in DRIVE_COLUMNS.items()
        ]
        table = ui.table(columns=columns, rows=[], row_key="axis").props(
            "flat dense hide-pagination"
        )
        table.classes("fp-table w-full")
    with page.card("Times of the bus in real time"):
        page.facts(TIMES)
    with page.card("Nodes"):
        nodes = ui.label("–").classes("fp-quiet")

    def refresh() -> None:
        table.rows = page.operator.link.state.axes(time.monotonic())
        nodes.set_text(", ".join(page.operator.link.nodes()) or "none")

    ui.timer(1.0, refresh)
