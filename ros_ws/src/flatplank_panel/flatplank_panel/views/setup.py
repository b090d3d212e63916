# SPDX-License-Identifier: Apache-2.0
"""Constants of the set-up, zero of the bridges, parasitic filter (R1.VI, R1.XI, R1.XII)."""

from __future__ import annotations

from typing import Any

from nicegui import ui

from flatplank_panel.service import FITS
from flatplank_panel.validation import CONSTANTS
from flatplank_panel.views.page import Page

LABELS = {
    "et_value": "ET value", "adapter_thickness": "Adapter", "wheel_camber_deg": "Wheel camber",
    "road_camber_offset_deg": "Road camber offset", "slip_angle_offset_deg": "Slip angle offset",
}  # fmt: skip
FILES = "*.yaml"


def build(page: Page) -> None:
    _constants(page)
    _filter(page)
    with page.card("Zero of the bridges"):
        ui.label("Lift the wheel and stop the plank first.").classes("fp-quiet")
        page.button("Take the zero", lambda: page.operator.tare(page.id))


def _constants(page: Page) -> None:
    fields: dict[str, Any] = {}
    with page.card("Constants"):
        with page.row():
            for name, constant in CONSTANTS.items():
                info = constant.info
                label = LABELS.get(name, name)
                fields[name] = page.number(label, info.default, info.unit).style("width:178px")
                fields[name].tooltip(info.description)

        async def load() -> None:
            before = {name: field.value for name, field in fields.items()}
            for name, value in (await page.operator.constants()).items():
                if fields[name].value == before[name]:  # else typed while the bench answered
                    fields[name].set_value(value)

        with page.row():
            page.button(
                "Set constants",
                lambda: page.operator.set_constants(
                    page.id, {n: f.value for n, f in fields.items()}
                ),
                strong=True,
            )
            page.button("Read from bench", load)


def _filter(page: Page) -> None:
    op = page.operator

    def fits() -> list[str]:
        found = sorted(op.data.glob(FILES)) + sorted(op.data.glob(f"{FITS}/{FILES}"))
        return [str(p.relative_to(op.data)) for p in found]

    async def look() -> None:
        file.set_options(fits())
        run.set_options(await page.service.unloaded_turns())

    async def identify() -> None:
        if not run.value:
            raise ValueError("choose the run of three unloaded turns first")
        found, left = await page.service.identify(run.value, mounting.value)
        words = (f"{name} {before:.1f} to {after:.1f} N" for name, (before, after) in left.items())
        result.set_text("Once per turn, before and after: " + ", ".join(words))
        file.set_options(fits(), value=found)
        await op.load_fit(page.id, found)

    with page.card("Parasitic filter"):
        with page.row():
            file = page.select("Fit of this mounting", fits(), None).props("clearable")
            page.refresh("Look for fits again", look)
        with page.row():
            page.button("Load", lambda: op.load_fit(page.id, file.value))
            page.button("Filter on", lambda: op.set_filter(page.id, True))
            page.button("Filter off", lambda: op.set_filter(page.id, False))
        with page.row():
            run = page.select("Run of three unloaded turns", [], None)
            mounting = page.text("Mounting", "mounting_1")
        with page.row():
            page.button("Identify from the run", identify)
            result = ui.label("").classes("fp-quiet")
